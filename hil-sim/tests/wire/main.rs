//! The simulated bus does what a CAN bus does, also where things go wrong, and
//! simulated time goes on whatever it does.

mod any_faults;
mod arbitration;
mod budget;
mod confinement;
mod faults;
mod rig;
mod steps;
