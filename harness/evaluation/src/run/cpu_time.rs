//! Time on processors of this program.

use std::time::Duration;

/// User and system, on all threads; `None` where the system does not report it.
#[cfg(target_os = "linux")]
pub fn own_cpu_time() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Some(Duration::new(time.tv_sec.try_into().ok()?, time.tv_nsec.try_into().ok()?))
}

/// User and system, on all threads; `None` where the system does not report it.
#[cfg(not(target_os = "linux"))]
pub fn own_cpu_time() -> Option<Duration> {
    None
}
