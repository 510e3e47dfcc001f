//! A trained support vector machine, and its part of a model file.

use super::model_file::{ModelFile, ModelFileError, f32_bytes, f32_numbers};

/// The part that holds it.
const SVM: &str = "support vector machine";
/// The coefficients of both classes cancel; this share of their sum is left over by rounding.
const MAX_IMBALANCE: f64 = 1e-4;

/// A trained ν support vector classifier of `D` values.
#[derive(Debug, Clone, PartialEq)]
pub struct SvmModel<const D: usize> {
    /// Width of the Gaussian kernel.
    pub gamma: f32,
    /// The ν it was trained with.
    pub nu: f64,
    /// Offset of the decision.
    pub rho: f32,
    /// Names of the values.
    pub features: [&'static str; D],
    /// Mean of each value over the training objects.
    pub means: [f32; D],
    /// Standard deviation of each value over the training objects.
    pub deviations: [f32; D],
    /// One for each support vector.
    pub coefficients: Vec<f32>,
    /// Standardised.
    pub support_vectors: Vec<[f32; D]>,
}

impl<const D: usize> SvmModel<D> {
    /// `file` with this classifier as a part: ν, γ, ρ, means, deviations, and each support vector behind its coefficient.
    pub fn put_into(&self, file: ModelFile) -> ModelFile {
        let support = self.coefficients.iter().zip(&self.support_vectors);
        let support = support.flat_map(|(coefficient, vector)| std::iter::once(coefficient).chain(vector));
        let numbers = [&self.gamma, &self.rho].into_iter().chain(&self.means).chain(&self.deviations);
        let mut bytes = self.nu.to_le_bytes().to_vec();
        bytes.extend(f32_bytes(numbers.chain(support)));
        file.with_part(SVM, self.features.map(str::to_owned).to_vec(), bytes)
    }

    /// The classifier of `features` in `file`.
    ///
    /// # Errors
    ///
    /// [`ModelFileError`] if there is none, it looks at other values, or is damaged.
    pub fn of(file: &ModelFile, features: [&'static str; D]) -> Result<Self, ModelFileError> {
        let bytes = file.part_of_values(SVM, &features)?;
        Self::of_bytes(bytes, features).filter(Self::is_sound).ok_or(ModelFileError::Part { name: SVM })
    }

    fn of_bytes(bytes: &[u8], features: [&'static str; D]) -> Option<Self> {
        let (nu, numbers) = bytes.split_first_chunk()?;
        let numbers = f32_numbers(numbers)?;
        let (&[gamma, rho], numbers) = numbers.split_first_chunk()?;
        let (&means, numbers) = numbers.split_first_chunk()?;
        let (&deviations, numbers) = numbers.split_first_chunk()?;
        let mut support = numbers.chunks_exact(D + 1);
        let rows = support.by_ref().map(|row| Some((row[0], <[f32; D]>::try_from(&row[1..]).ok()?)));
        let (coefficients, support_vectors) = rows.collect::<Option<Vec<_>>>()?.into_iter().unzip();
        let nu = f64::from_le_bytes(*nu);
        let model = Self { gamma, nu, rho, features, means, deviations, coefficients, support_vectors };
        support.remainder().is_empty().then_some(model)
    }

    /// Whether training can have produced these numbers. They are finite.
    fn is_sound(&self) -> bool {
        let sum: f64 = self.coefficients.iter().map(|&it| f64::from(it)).sum();
        let size: f64 = self.coefficients.iter().map(|&it| f64::from(it).abs()).sum();
        self.nu > 0.0
            && self.nu <= 1.0
            && self.gamma > 0.0
            && self.deviations.iter().all(|&it| it > 0.0)
            && size > 0.0
            && sum.abs() <= MAX_IMBALANCE * size
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::describe::trained_file::Provenance;

    fn model() -> SvmModel<2> {
        SvmModel {
            gamma: 0.1078,
            nu: 0.0377,
            rho: -0.3,
            features: ["length_m", "width_m"],
            means: [4.2, 1.8],
            deviations: [1.0e-7, 0.5],
            coefficients: vec![1.5, -0.5, -1.0],
            support_vectors: vec![[0.1, f32::MIN_POSITIVE], [-1.0, 2.0], [1.0 / 3.0, 0.0]],
        }
    }

    fn file() -> ModelFile {
        ModelFile::new("chairs", Provenance::default(), toml::Table::new())
    }

    #[test]
    fn a_model_comes_back_from_its_file_to_the_bit() {
        let model = model();
        assert_eq!(SvmModel::of(&model.put_into(file()), model.features), Ok(model));
    }

    #[test]
    fn what_no_training_gives_is_refused() {
        let changes: [fn(&mut SvmModel<2>); 9] = [
            |it| it.nu = 0.0,
            |it| it.nu = f64::NAN,
            |it| it.gamma = -1.0,
            |it| it.rho = f32::INFINITY,
            |it| it.deviations[0] = 0.0,
            |it| it.means[1] = f32::NAN,
            |it| it.coefficients[1] = -0.4,
            |it| it.support_vectors[1][0] = f32::NAN,
            |it| it.support_vectors.clear(),
        ];
        for change in changes {
            let mut changed = model();
            change(&mut changed);
            let read = SvmModel::of(&changed.put_into(file()), changed.features);
            assert_eq!(read, Err(ModelFileError::Part { name: SVM }), "{changed:?}");
        }
        let cut = file().with_part(SVM, model().features.map(str::to_owned).to_vec(), vec![0; 30]);
        assert_eq!(SvmModel::of(&cut, model().features), Err(ModelFileError::Part { name: SVM }));
    }

    #[test]
    fn other_values_are_named() {
        let error = SvmModel::of(&model().put_into(file()), ["length_m", "depth_m"]).unwrap_err().to_string();
        assert!(error.contains("looks at the values length_m, width_m, not at length_m, depth_m"), "{error}");
    }
}
