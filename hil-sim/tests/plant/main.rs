//! The plant: how the simulated robot moves.
#![allow(missing_docs, reason = "tests have no readers of their documentation")]

mod accuracy;
mod energy;
mod lifted_wheel;
mod oracle;
mod paper;
mod sticking;
mod symmetry;
mod work;
