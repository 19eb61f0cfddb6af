//! stub
use crate::plant::Plant;
use canloop::config::Problem;
use std::io::Write;
/// s
pub struct TorqueRow;
/// s
pub fn read(_: &std::path::Path) -> Result<Vec<TorqueRow>, Problem> {
    Err(Problem::bare("x"))
}
/// s
pub fn run_open_loop(_: Plant, _: &[TorqueRow], _: &mut impl Write) -> std::io::Result<()> {
    Ok(())
}
