//! Logs of buses in all formats: what is read is what is in them, what is
//! written comes back, and what is lost is said.

mod binary_dialects;
mod command;
mod corpus;
mod damage;
mod dialects;
mod matrix;
mod other_tools;
mod rig;
mod traffic;
