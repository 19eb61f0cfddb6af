//! Whether this kernel has CAN at all.

use rustix::io::Errno;
use rustix::net::{AddressFamily, Protocol, SocketFlags, SocketType};

use super::{Check, Machine, kernel};

const KERNEL_CAN: &str = "kernel CAN";

/// Tries a raw CAN socket, which loads the modules where there are any.
/// `needed` says whether the bus that was asked for is one of the kernel's.
pub(super) fn check(machine: &Machine, needed: bool) -> Check {
    let release = kernel::release(machine).unwrap_or_default();
    let modules = machine.text(&format!("lib/modules/{release}/modules.dep")).unwrap_or_default();
    judge(open_socket(), modules.contains("/can-raw.ko"), needed)
}

fn open_socket() -> Result<(), Errno> {
    // `CAN_RAW` in `linux/can.h`.
    let raw = std::num::NonZeroU32::MIN;
    let protocol = Some(Protocol::from_raw(raw));
    rustix::net::socket_with(AddressFamily::CAN, SocketType::RAW, SocketFlags::CLOEXEC, protocol).map(drop)
}

/// Asking for an interface would say no more than that there is none.
fn judge(opened: Result<(), Errno>, has_module: bool, needed: bool) -> Check {
    let (found, mend) = match opened {
        Ok(()) => return Check::ok(KERNEL_CAN, "raw sockets can be had"),
        Err(Errno::AFNOSUPPORT | Errno::PROTONOSUPPORT) if has_module => {
            ("its modules are there, but not loaded".to_owned(), "modprobe can-raw")
        }
        Err(Errno::AFNOSUPPORT | Errno::PROTONOSUPPORT) => (
            "this kernel has no CAN sockets and no modules for them".to_owned(),
            "scripts/with-vcan COMMAND # runs COMMAND where vcan0 exists; for a card, start a kernel with CONFIG_CAN",
        ),
        Err(error @ (Errno::ACCESS | Errno::PERM)) => (
            format!("forbidden, as sandboxes and containers do: {error}"),
            "scripts/with-vcan COMMAND # or allow AF_CAN sockets in the container's seccomp profile",
        ),
        Err(error) => (format!("no raw socket: {error}"), "dmesg | grep -i can"),
    };
    match needed {
        true => Check::missing(KERNEL_CAN, found, mend),
        false => Check::degraded(KERNEL_CAN, found, mend),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Outcome;
    use super::*;

    #[test]
    fn a_kernel_without_can_is_missing_only_where_it_is_needed() {
        assert_eq!(judge(Ok(()), false, true).outcome, Outcome::Ok);
        assert_eq!(judge(Err(Errno::AFNOSUPPORT), false, false).outcome, Outcome::Degraded);
        assert_eq!(judge(Err(Errno::AFNOSUPPORT), false, true).outcome, Outcome::Missing);
    }

    #[test]
    fn the_mend_depends_on_whether_there_are_modules() {
        let mend = |opened, has_module| judge(Err(opened), has_module, true).mend.unwrap();
        assert_eq!(mend(Errno::AFNOSUPPORT, true), "modprobe can-raw");
        assert_eq!(mend(Errno::PROTONOSUPPORT, true), "modprobe can-raw");
        assert!(mend(Errno::AFNOSUPPORT, false).contains("scripts/with-vcan"));
        assert!(mend(Errno::PERM, true).contains("seccomp"));
        assert!(mend(Errno::MFILE, true).contains("dmesg"));
    }
}
