//! Computers as fast as the one that times are of, or by a factor faster or slower.

/// How many times as fast as the machine of the times a computer is.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct MachineSpeed(f64);

/// Half octaves to either side of this machine.
const STEPS: i32 = 8;

impl MachineSpeed {
    /// The machine of the times.
    pub const THIS: Self = Self(1.0);

    /// From a sixteenth of this machine to sixteen times as fast, in steps of √2.
    pub fn all() -> impl Iterator<Item = Self> {
        (-STEPS..=STEPS).map(|it| Self((0.5 * f64::from(it)).exp2()))
    }

    /// The factor.
    pub fn factor(self) -> f64 {
        self.0
    }

    /// What takes `time_ms` on the machine of the times takes this long.
    pub fn time_ms(self, time_ms: f64) -> f64 {
        time_ms / self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_are_powers_of_the_root_of_two_around_this_machine() {
        let all: Vec<f64> = MachineSpeed::all().map(MachineSpeed::factor).collect();
        assert_eq!((all.len(), all[0], all[8], all[10], all[16]), (17, 1.0 / 16.0, 1.0, 2.0, 16.0));
        assert_eq!(MachineSpeed(4.0).time_ms(100.0), 25.0);
    }
}
