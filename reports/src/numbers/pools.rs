//! Data sets whose numbers are put together.

use crate::vocabulary::extent::Extent;
use crate::vocabulary::origin::Origin;

/// All data sets of one origin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pool {
    /// Extent of the numbers about them: the data set itself if it is the only one.
    pub extent: Extent,
    /// Where their scans come from.
    pub origin: Origin,
    /// Their ids.
    pub datasets: Vec<String>,
}

impl Pool {
    /// Words that tell this pool from others.
    pub fn in_words(&self) -> String {
        let origin = self.origin.name();
        match &self.extent {
            Extent::Dataset(id) => format!("{id} ({origin})"),
            Extent::Overall | Extent::OverallOf(_) => format!("{} {origin} data sets", self.datasets.len()),
        }
    }

    /// Whether it has several data sets, so that numbers about them together differ from those of each.
    pub fn is_of_several(&self) -> bool {
        self.extent.is_overall()
    }
}

/// A pool for each origin among `datasets`, which are ids with origins; first the pool of the first data set.
pub fn pools<'a>(datasets: impl IntoIterator<Item = (&'a str, Origin)>) -> Vec<Pool> {
    let mut pools: Vec<Pool> = Vec::new();
    for (id, origin) in datasets {
        match pools.iter_mut().find(|it| it.origin == origin) {
            Some(pool) => {
                pool.extent = Extent::OverallOf(origin);
                pool.datasets.push(id.to_owned());
            }
            None => pools.push(Pool {
                extent: Extent::Dataset(id.to_owned()),
                origin,
                datasets: vec![id.to_owned()],
            }),
        }
    }
    if let [only] = &mut pools[..]
        && only.is_of_several()
    {
        only.extent = Extent::Overall;
    }
    pools
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(datasets: &[(&str, Origin)]) -> Vec<(String, usize)> {
        let pools = pools(datasets.iter().copied());
        pools.iter().map(|it| (it.extent.name().to_owned(), it.datasets.len())).collect()
    }

    #[test]
    fn only_data_sets_of_one_origin_are_put_together() {
        let (recorded, simulated) = (Origin::Recorded, Origin::Simulated);
        assert_eq!(names(&[]), []);
        assert_eq!(names(&[("a", simulated)]), [("a".to_owned(), 1)]);
        assert_eq!(names(&[("a", simulated), ("b", simulated)]), [("overall".to_owned(), 2)]);
        let mixed = [("a", simulated), ("kitti", recorded), ("b", simulated)];
        assert_eq!(names(&mixed), [("overall-simulated".to_owned(), 2), ("kitti".to_owned(), 1)]);
    }
}
