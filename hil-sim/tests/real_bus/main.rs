//! The stack and its far side as two programs, `canloop drive` and `hil-sim
//! serve`, on a bus between them.
//!
//! Tests on the kernel's interfaces are marked as ignored: they run where
//! those exist, which the tests below see to.

#![cfg(target_os = "linux")]

mod bad_bus;
mod candump_beside_a_run;
mod dead_other_side;
mod garbage_on_the_bus;
mod lockstep_over_every_bus;
mod path_kept_with_every_drive;
mod python_controller;
mod readme_example;
mod two_programs;
mod with_can;

#[path = "../rig/mod.rs"]
mod rig;

use self::with_can::run_where_there_is;

#[test]
fn all_of_it_holds_on_the_kernels_virtual_bus() {
    run_where_there_is("with-vcan", "over_vcan");
}

#[test]
fn every_kind_of_drive_keeps_to_the_path_on_the_kernels_virtual_bus() {
    run_where_there_is("with-vcan", "with_every_drive_on_vcan");
}

#[test]
fn all_of_it_holds_on_two_emulated_cards() {
    run_where_there_is("with-can-card", "over_a_card");
}
