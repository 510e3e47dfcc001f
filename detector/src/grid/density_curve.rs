//! How the density of points falls with the range, learned from scans.

use nalgebra::{DMatrix, DVector};
use serde::Deserialize;

use super::nonnegative_least_squares::nonnegative_least_squares;
use super::ring_density::{FIRST_RING_M, LAST_RING_END_M, N_RINGS, RingCounts, ring_area_m2, ring_middle_m};

use crate::portable_math;

/// Layout and meaning of a written [`DensityCurve`]; raised when either changes.
pub const CURVE_VERSION: u32 = 1;
/// Degree of the polynomial, as in the paper.
const DEGREE: usize = 6;
/// A ring with fewer points says too little about its density: it is left out of the fit.
pub const LEAST_POINTS: u64 = 20;
/// Name of the densities of the rings in errors.
const RINGS: &str = "density_weighting.curve.ring_points_per_m2";

/// The density of each ring around a sensor, the weight fitted to it, and their origin.
///
/// The weight at range r is exp(−p(r / 80 m)), with p the polynomial of the sixth degree that has
/// [`Self::coefficients`] in the Bernstein basis. They start at or above 0 and never fall, hence neither does p: the weight
/// is positive, at most 1, and never rises, whatever it was fitted to. The paper fits the weight itself; densities span
/// four powers of ten between the first ring and the last, which no falling polynomial of that degree follows.
///
/// Paper: HG section 4 and Fig. 5.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DensityCurve {
    /// [`CURVE_VERSION`] when it was written.
    pub version: u32,
    /// The sensor.
    pub sensor: String,
    /// The data sets.
    pub datasets: Vec<String>,
    /// Seeds of the simulated ones among them.
    pub seeds: Vec<u64>,
    /// Number of scans.
    pub n_scans: u64,
    /// The command that made it.
    pub command: String,
    /// Density of the densest ring, in points per square metre and scan.
    pub peak_points_per_m2: f64,
    /// Coefficients of the logarithm of the weight, with the sign changed, in the Bernstein basis over r / 80 m.
    pub coefficients: [f64; DEGREE + 1],
    /// Density of each ring, in points per square metre and scan.
    pub ring_points_per_m2: Vec<f64>,
}

/// Origin of a curve.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CurveOrigin {
    /// See [`DensityCurve::sensor`].
    pub sensor: String,
    /// See [`DensityCurve::datasets`].
    pub datasets: Vec<String>,
    /// See [`DensityCurve::seeds`].
    pub seeds: Vec<u64>,
    /// See [`DensityCurve::command`].
    pub command: String,
}

/// Why a curve cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{field} = {value} is not within {allowed}")]
pub struct ImplausibleCurve {
    /// The field, as parameters of the detector are called.
    pub field: &'static str,
    /// The implausible value.
    pub value: f64,
    /// The plausible values.
    pub allowed: &'static str,
}

/// Too few rings to fit a curve.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("only {n_rings} of {N_RINGS} rings have {LEAST_POINTS} points or more, but the fit needs {least}")]
pub struct TooFewRings {
    /// Rings with enough points.
    pub n_rings: usize,
    /// Rings that are needed.
    pub least: usize,
}

/// Sensors and the curves that come with the detector, as `scanbench fit-density` wrote them from simulated scans.
const SHIPPED: [(&str, &str); 5] = [
    ("hdl-64e-s2", include_str!("../params/density/hdl-64e-s2.toml")),
    ("hdl-32e", include_str!("../params/density/hdl-32e.toml")),
    ("vlp-16", include_str!("../params/density/vlp-16.toml")),
    ("os1-128", include_str!("../params/density/os1-128.toml")),
    ("argoverse2", include_str!("../params/density/argoverse2.toml")),
];

impl DensityCurve {
    /// The curve of `sensor`, if one comes with the detector.
    pub fn shipped(sensor: &str) -> Option<Self> {
        let table = Self::shipped_table(sensor)?;
        Some(table.try_into().expect("every shipped file is read by a test"))
    }

    /// The curve of `sensor` as the table `density_weighting.curve` of the parameters, if one comes with the detector.
    pub fn shipped_table(sensor: &str) -> Option<toml::Table> {
        let (_, text) = SHIPPED.iter().find(|(known, _)| *known == sensor)?;
        let file: toml::Table = text.parse().expect("every shipped file is read by a test");
        file["hierarchical"]["density_weighting"]["curve"].as_table().cloned()
    }

    /// The curve fitted to scans with these points in their rings.
    ///
    /// Rings nearer than the densest one count as dense as that: ground so near is shaded by the sensor's carrier, and the
    /// paper leaves the density there as it is. Every ring that counts weighs the same in the least squares of the
    /// logarithm. Numbers are rounded to six digits, so that every machine writes the same.
    ///
    /// # Errors
    ///
    /// [`TooFewRings`] if there are fewer rings with enough points than coefficients.
    pub fn fit(scans: &[RingCounts], origin: CurveOrigin) -> Result<Self, TooFewRings> {
        let mut n_points = [0_u64; N_RINGS];
        for scan in scans {
            n_points.iter_mut().zip(scan.n_points()).for_each(|(sum, n)| *sum += n);
        }
        let density = |ring_idx: usize| {
            rounded(n_points[ring_idx] as f64 / (ring_area_m2(ring_idx) * scans.len().max(1) as f64))
        };
        let ring_points_per_m2: Vec<f64> = (0..N_RINGS).map(density).collect();
        let counted = || (0..N_RINGS).filter(|&ring_idx| n_points[ring_idx] >= LEAST_POINTS);
        let densest = counted().max_by(|&p, &q| density(p).total_cmp(&density(q)).then(q.cmp(&p)));
        let n_rings = counted().count();
        let Some(densest) = densest.filter(|_| n_rings > DEGREE) else {
            return Err(TooFewRings { n_rings, least: DEGREE + 1 });
        };
        let peak_points_per_m2 = ring_points_per_m2[densest];
        // Near and densest rings, counted or not, have weight 1 and logarithm 0.
        let beyond = counted().filter(|&ring_idx| ring_idx > densest);
        let targets: Vec<(f64, f64)> = (0..=densest)
            .map(|ring_idx| (ring_middle_m(ring_idx), 0.0))
            .chain(beyond.map(|it| {
                (ring_middle_m(it), portable_math::ln(peak_points_per_m2 / ring_points_per_m2[it]))
            }))
            .collect();
        let CurveOrigin { sensor, datasets, seeds, command } = origin;
        Ok(Self {
            version: CURVE_VERSION,
            sensor,
            datasets,
            seeds,
            n_scans: scans.len() as u64,
            command,
            peak_points_per_m2,
            coefficients: fit_coefficients(&targets),
            ring_points_per_m2,
        })
    }

    /// The weight at `range_m`, above 0 and at most 1; that of 1 m for nearer ranges, of 80 m for farther ones.
    pub fn weight(&self, range_m: f64) -> f64 {
        let mut values = self.coefficients;
        let t = share_of_range(range_m);
        // De Casteljau: means of means stay in order, so that rounding does not make the curve rise either.
        for n_left in (1..values.len()).rev() {
            for idx in 0..n_left {
                values[idx] += t * (values[idx + 1] - values[idx]);
            }
        }
        portable_math::exp(-values[0])
    }

    /// The curve as an overriding configuration for `scanbench run --config`, and as the files that come with the detector.
    pub fn to_toml(&self) -> String {
        let texts = |values: &[String]| values.iter().map(|it| quoted(it)).collect::<Vec<_>>().join(", ");
        let numbers =
            |values: &[f64]| values.iter().map(|it| format!("{it:?}")).collect::<Vec<_>>().join(", ");
        let seeds = self.seeds.iter().map(u64::to_string).collect::<Vec<_>>().join(", ");
        let rings: String = self
            .ring_points_per_m2
            .chunks(10)
            .fold(String::new(), |lines, chunk| lines + "    " + &numbers(chunk) + ",\n");
        format!(
            "# How the density of points falls with the range, learned from scans.\n\
             # The weight at range r is exp(-p(r / 80 m)), with p of the sixth degree in the Bernstein basis.\n\
             \n\
             [hierarchical.density_weighting.curve]\n\
             version = {}\nsensor = {}\ndatasets = [{}]\nseeds = [{seeds}]\nn_scans = {}\ncommand = {}\n\
             peak_points_per_m2 = {:?}\ncoefficients = [{}]\n\
             # One value a ring of a metre, the first from 1 to 2 m.\n\
             ring_points_per_m2 = [\n{rings}]\n",
            self.version,
            quoted(&self.sensor),
            texts(&self.datasets),
            self.n_scans,
            quoted(&self.command),
            self.peak_points_per_m2,
            numbers(&self.coefficients),
        )
    }

    /// Refuses curves that [`Self::fit`] never makes.
    ///
    /// # Errors
    ///
    /// [`ImplausibleCurve`] for the first implausible value.
    pub fn check(&self) -> Result<(), ImplausibleCurve> {
        let within = |field, value: f64, low: f64, high: f64, allowed| {
            let is_plausible = (low..=high).contains(&value);
            is_plausible.then_some(()).ok_or(ImplausibleCurve { field, value, allowed })
        };
        let version = f64::from(CURVE_VERSION);
        within(
            "density_weighting.curve.version",
            self.version.into(),
            version,
            version,
            "what this program reads, which is 1",
        )?;
        within(
            "density_weighting.curve.peak_points_per_m2",
            self.peak_points_per_m2,
            1e-3,
            1e9,
            "0.001 to 10^9 points",
        )?;
        let mut least = 0.0;
        for coefficient in self.coefficients {
            within(
                "density_weighting.curve.coefficients",
                coefficient,
                least,
                100.0,
                "0 to 100 in ascending order",
            )?;
            least = coefficient;
        }
        let n_rings = self.ring_points_per_m2.len() as f64;
        within(RINGS, n_rings, N_RINGS as f64, N_RINGS as f64, "79 values")?;
        self.ring_points_per_m2.iter().try_for_each(|&density| {
            within(RINGS, density, 0.0, self.peak_points_per_m2, "0 to peak_points_per_m2")
        })
    }
}

/// The argument of the polynomial.
fn share_of_range(range_m: f64) -> f64 {
    let end_m = LAST_RING_END_M as f64;
    range_m.clamp(FIRST_RING_M as f64, end_m) / end_m
}

/// Ascending coefficients of the polynomial that comes nearest to the `targets`, pairs of range and value.
fn fit_coefficients(targets: &[(f64, f64)]) -> [f64; DEGREE + 1] {
    // Its unknowns are the steps from one coefficient to the next: steps of at least 0 add up to ascending coefficients.
    let basis = DMatrix::from_fn(targets.len(), DEGREE + 1, |row, column| {
        let bernstein = bernstein(share_of_range(targets[row].0));
        bernstein[column..].iter().sum::<f64>()
    });
    let values = DVector::from_iterator(targets.len(), targets.iter().map(|&(_, value)| value));
    let steps = nonnegative_least_squares(&basis, &values);
    let mut sum = 0.0;
    std::array::from_fn(|idx| {
        sum += steps[idx];
        rounded(sum)
    })
}

/// The Bernstein polynomials of the sixth degree at `t`.
fn bernstein(t: f64) -> [f64; DEGREE + 1] {
    const BINOMIAL: [f64; DEGREE + 1] = [1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0];
    std::array::from_fn(|idx| BINOMIAL[idx] * t.powi(idx as i32) * (1.0 - t).powi((DEGREE - idx) as i32))
}

/// Text as TOML writes it.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A number rounded to six significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().expect("what was written as a number is one")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{HierarchicalParams, ParamsError};
    use proptest::prelude::*;

    fn origin() -> CurveOrigin {
        CurveOrigin {
            sensor: "a \"sensor\"".to_owned(),
            datasets: vec!["street".to_owned(), "b\\c".to_owned()],
            seeds: vec![1, 1],
            command: "scanbench fit-density street".to_owned(),
        }
    }

    /// The fit to rings of these densities; `n_points` of a ring is density times area, to whole points.
    fn fitted(density: impl Fn(f64) -> f64) -> Result<DensityCurve, TooFewRings> {
        let counts =
            std::array::from_fn(|idx| (density(ring_middle_m(idx)) * ring_area_m2(idx)).round() as u64);
        DensityCurve::fit(&[RingCounts::from_n_points(counts)], origin())
    }

    #[track_caller]
    fn check_weight(curve: &DensityCurve, range_m: f64, expected: f64, factor: f64) {
        let ratio = curve.weight(range_m) / expected;
        assert!((1.0 / factor..factor).contains(&ratio), "{} at {range_m} m", curve.weight(range_m));
    }

    #[test]
    fn what_the_basis_can_express_is_found_again() {
        // The logarithm is 12 t^2, whose Bernstein coefficients ascend.
        let curve = fitted(|range_m| 1e9 * (-12.0 * (range_m / 80.0).powi(2)).exp()).unwrap();
        for range_m in [1.5, 10.5, 40.5, 79.5] {
            check_weight(&curve, range_m, (-12.0 * (range_m / 80.0).powi(2)).exp(), 1.01);
        }
    }

    #[test]
    fn over_level_ground_the_weight_follows_the_cube_of_the_range() {
        let curve = fitted(|range_m| 1e8 * range_m.max(4.5).powi(-3)).unwrap();
        assert_eq!(
            curve.peak_points_per_m2,
            rounded(curve.ring_points_per_m2[..4].iter().copied().fold(0.0, f64::max))
        );
        for range_m in [6.5, 10.5, 20.5, 40.5, 79.5] {
            check_weight(&curve, range_m, (4.5 / range_m).powi(3), 1.8);
        }
    }

    #[test]
    fn what_is_shaded_near_the_sensor_keeps_its_density() {
        let curve =
            fitted(|range_m| if range_m < 4.0 { 0.0 } else { 1e5 * (-range_m / 10.0).exp() }).unwrap();
        assert!(curve.weight(1.5) > 0.9 && curve.weight(20.5) < 0.3);
        assert_eq!(curve.ring_points_per_m2[0], 0.0);
    }

    #[test]
    fn a_written_curve_is_read_again() {
        let curve = fitted(|range_m| 1e6 / range_m).unwrap();
        let file: toml::Table = curve.to_toml().parse().unwrap();
        let table = file["hierarchical"]["density_weighting"]["curve"].as_table().unwrap();
        assert_eq!(table.clone().try_into::<DensityCurve>().unwrap(), curve);
        assert_eq!(curve.check(), Ok(()));
    }

    #[test]
    fn shipped_files_are_as_they_would_be_written_and_made_of_simulated_scans() {
        for (sensor, text) in SHIPPED {
            let curve = DensityCurve::shipped(sensor).unwrap();
            assert_eq!(curve.to_toml(), text);
            assert_eq!((curve.sensor.as_str(), curve.check()), (sensor, Ok(())));
            assert_eq!(curve.seeds.len(), curve.datasets.len(), "{sensor}");
            // The densities in the file give the weights in the file.
            let counts =
                |idx: usize| curve.ring_points_per_m2[idx] * ring_area_m2(idx) * curve.n_scans as f64;
            let scans = [RingCounts::from_n_points(std::array::from_fn(|idx| counts(idx).round() as u64))];
            let again = DensityCurve::fit(&scans, origin()).unwrap();
            for range_m in (1..=80).map(f64::from) {
                check_weight(&again, range_m, curve.weight(range_m), 1.01);
            }
        }
    }

    #[test]
    fn sensors_differ() {
        let weights =
            ["hdl-64e-s2", "vlp-16"].map(|it| DensityCurve::shipped(it).unwrap().peak_points_per_m2);
        assert!(weights[0] > 2.0 * weights[1], "{weights:?}");
        assert_eq!(DensityCurve::shipped("hdl-65"), None);
    }

    #[test]
    fn too_few_rings_are_an_error() {
        let six = |range_m: f64| if range_m < 7.0 { 1e4 } else { 0.0 };
        assert_eq!(fitted(six), Err(TooFewRings { n_rings: 6, least: 7 }));
        assert_eq!(DensityCurve::fit(&[], origin()), Err(TooFewRings { n_rings: 0, least: 7 }));
    }

    #[track_caller]
    fn check_refused(key: &str, value: &str, message: &str) {
        let mut table = HierarchicalParams::shipped_table();
        let value: toml::Table = format!("it = {value}").parse().unwrap();
        table["density_weighting"]["curve"][key] = value["it"].clone();
        let error: ParamsError = HierarchicalParams::from_toml(&table.to_string()).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }

    #[test]
    fn damaged_curves_are_refused() {
        check_refused(
            "version",
            "2",
            "density_weighting.curve.version = 2 is not within what this program reads",
        );
        check_refused(
            "coefficients",
            "[0.0, 2.0, 1.0, 3.0, 4.0, 5.0, 6.0]",
            "curve.coefficients = 1 is not within",
        );
        check_refused(
            "coefficients",
            "[-1.0, 2.0, 2.0, 3.0, 4.0, 5.0, 6.0]",
            "curve.coefficients = -1 is not within",
        );
        check_refused(
            "coefficients",
            "[0.0, nan, 2.0, 3.0, 4.0, 5.0, 6.0]",
            "curve.coefficients = NaN is not within",
        );
        check_refused("coefficients", "[0.0, 1.0]", "invalid length 2");
        check_refused("peak_points_per_m2", "0.0", "curve.peak_points_per_m2 = 0 is not within");
        check_refused("ring_points_per_m2", "[1.0]", "curve.ring_points_per_m2 = 1 is not within 79 values");
        check_refused("sensor", "7", "invalid type");
    }

    proptest! {
        #[test]
        fn whatever_was_seen_the_weight_is_positive_and_never_rises(
            n_points in prop::collection::vec(prop_oneof![Just(0_u64), 0..100_u64, 0..10_000_000_u64], N_RINGS),
        ) {
            let counts = RingCounts::from_n_points(n_points.try_into().unwrap());
            if let Ok(curve) = DensityCurve::fit(&[counts], origin()) {
                prop_assert_eq!(curve.check(), Ok(()));
                let weights: Vec<f64> = (0..=900).map(|decimetres| curve.weight(f64::from(decimetres) / 10.0)).collect();
                prop_assert!(weights.iter().all(|&it| it > 0.0 && it <= 1.0));
                prop_assert!(weights.is_sorted_by(|near, far| near >= far));
            }
        }

        #[test]
        fn any_curve_that_is_not_refused_is_positive_and_never_rises(steps in prop::array::uniform7(0.0..10.0_f64)) {
            let mut curve = DensityCurve::shipped("hdl-64e-s2").unwrap();
            let mut sum = 0.0;
            curve.coefficients = steps.map(|step| { sum += step; sum });
            prop_assert_eq!(curve.check(), Ok(()));
            let weights: Vec<f64> = (0..=160).map(|half| curve.weight(f64::from(half) / 2.0)).collect();
            prop_assert!(weights.iter().all(|&it| it > 0.0 && it <= 1.0));
            prop_assert!(weights.is_sorted_by(|near, far| near >= far));
        }
    }
}
