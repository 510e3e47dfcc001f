//! Points grouped by the object they belong to.

/// Groups of points, in one reusable buffer.
#[derive(Debug, Clone, Default)]
pub struct Clusters {
    // Invariant: ascending, one longer than there are clusters, the last is the length of `members`.
    starts: Vec<u32>,
    members: Vec<u32>,
    next_free: Vec<u32>,
    cluster_of_label: Vec<u32>,
}

const NO_CLUSTER: u32 = u32::MAX;

impl Clusters {
    /// Groups the elements `0..labels.len()` by label, clusters in the order of their first member.
    ///
    /// Labels lie below `n_labels`.
    pub fn group(&mut self, labels: impl Iterator<Item = u32> + Clone, n_labels: usize) {
        self.cluster_of_label.clear();
        self.cluster_of_label.resize(n_labels, NO_CLUSTER);
        self.starts.clear();
        self.starts.push(0);
        for label in labels.clone() {
            let cluster = &mut self.cluster_of_label[label as usize];
            if *cluster == NO_CLUSTER {
                *cluster = self.starts.len() as u32 - 1;
                self.starts.push(0);
            }
            // For now the size of a cluster stands at its end.
            self.starts[*cluster as usize + 1] += 1;
        }
        for cluster in 1..self.starts.len() {
            self.starts[cluster] += self.starts[cluster - 1];
        }
        self.next_free.clear();
        self.next_free.extend_from_slice(&self.starts);
        self.members.clear();
        self.members.resize(self.starts.last().map_or(0, |&n| n as usize), 0);
        for (label, element) in labels.zip(0..) {
            let index = &mut self.next_free[self.cluster_of_label[label as usize] as usize];
            self.members[*index as usize] = element;
            *index += 1;
        }
    }

    /// Number of clusters.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there is no cluster.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The members of cluster `cluster_idx`, ascending.
    pub fn members(&self, cluster_idx: usize) -> &[u32] {
        &self.members[self.starts[cluster_idx] as usize..self.starts[cluster_idx + 1] as usize]
    }

    /// The members of each cluster, ascending.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        self.starts.windows(2).map(|ends| &self.members[ends[0] as usize..ends[1] as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn equal_labels_and_nothing_else_share_a_cluster(labels in prop::collection::vec(0_u32..9, 0..60)) {
            let mut clusters = Clusters::default();
            clusters.group(labels.iter().copied(), 9);
            let mut cluster_of = vec![usize::MAX; labels.len()];
            for (cluster_idx, members) in clusters.iter().enumerate() {
                prop_assert!(members.windows(2).all(|pair| pair[0] < pair[1]));
                for &member in members {
                    cluster_of[member as usize] = cluster_idx;
                }
            }
            for (a, label_a) in labels.iter().enumerate() {
                for (b, label_b) in labels.iter().enumerate() {
                    prop_assert_eq!(label_a == label_b, cluster_of[a] == cluster_of[b]);
                }
            }
            prop_assert!(cluster_of.iter().all(|&cluster_idx| cluster_idx < clusters.len()));
        }
    }
}
