//! The scans of a run in its order.

use reports::rows::scan_row::ScanRow;

/// Data set, drive and number within the drive of a scan.
pub type ScanKey = (String, String, u32);

/// The scans of these rows of a run, in their order; a scan has rows for every detector and task.
pub fn scans_in_order(rows: &[ScanRow]) -> Vec<ScanKey> {
    let mut order: Vec<ScanKey> = Vec::new();
    for row in rows {
        let key = (row.dataset.clone(), row.sequence.clone(), row.scan);
        if order.last() != Some(&key) {
            order.push(key);
        }
    }
    order
}
