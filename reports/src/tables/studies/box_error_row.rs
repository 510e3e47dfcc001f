//! `boxes.csv`, one row for every matched vehicle and fit, `box_errors.csv`, one for every median, and `box_points.csv`, one
//! for every cell.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::numbers::blocks::BlockColumns;
use crate::numbers::box_errors::BoxErrorLine;
use crate::numbers::box_points::{BoxPoints, CELL_M};
use crate::vocabulary::class::{AnnotationClass, Occlusion};

row! {
    /// A box fitted to the cluster of a matched vehicle.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct FittedBoxRow {
        data: String,
        simulated: bool,
        scan: String,
        class: AnnotationClass,
        track: Option<u32>,
        occlusion: Option<Occlusion>,
        range_m: Fixed<2>,
        n_points: usize,
        fit: String,
        centre_error_m: Fixed<4>,
        length_error_m: Fixed<4>,
        width_error_m: Fixed<4>,
        yaw_error_deg: Fixed<3>,
        front_right: bool,
        front_sure: Option<bool>,
        bev_iou: Fixed<4>,
        iou_3d: Fixed<4>,
    }
}

/// The vehicle that a box was fitted to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchedVehicle<'a> {
    /// The data set.
    pub data: &'a str,
    /// Whether it is simulated.
    pub is_simulated: bool,
    /// The scan.
    pub scan: &'a str,
    /// Its class.
    pub class: AnnotationClass,
    /// Its number within its drive.
    pub track: Option<u32>,
    /// How much of it is hidden.
    pub occlusion: Option<Occlusion>,
    /// Distance of its annotation from the sensor, in metres.
    pub range_m: f64,
    /// Points of the cluster.
    pub n_points: usize,
}

impl FittedBoxRow {
    /// The row of `fit`, which is off by so much: centre, length (fitted less annotated) and width in metres, yaw in
    /// degrees; its intersections over union from above and in space; whether its front is on the right side, and whether
    /// the detector is sure of that.
    pub fn new(
        vehicle: MatchedVehicle<'_>,
        fit: &str,
        [centre, length, width, yaw, bev_iou, iou_3d]: [f64; 6],
        is_front_right: bool,
        is_front_sure: Option<bool>,
    ) -> Self {
        Self {
            data: vehicle.data.to_owned(),
            simulated: vehicle.is_simulated,
            scan: vehicle.scan.to_owned(),
            class: vehicle.class,
            track: vehicle.track,
            occlusion: vehicle.occlusion,
            range_m: Fixed(vehicle.range_m),
            n_points: vehicle.n_points,
            fit: fit.to_owned(),
            centre_error_m: Fixed(centre),
            length_error_m: Fixed(length),
            width_error_m: Fixed(width),
            yaw_error_deg: Fixed(yaw),
            front_right: is_front_right,
            front_sure: is_front_sure,
            bev_iou: Fixed(bev_iou),
            iou_3d: Fixed(iou_3d),
        }
    }
}

row! {
    /// A cell in the frame of the boxes of a class.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct BoxPointsRow {
        data: String,
        simulated: bool,
        class: AnnotationClass,
        frame: String,
        vehicles: usize,
        along_m: Fixed<2>,
        across_m: Fixed<2>,
        share: Fixed<6>,
    }
}

impl BoxPointsRow {
    /// The rows of `points`: where each cell begins, along the length to the front and across to the left of the centre, and
    /// its share.
    pub fn of<'a>(
        data: &'a str,
        is_simulated: bool,
        points: &'a BoxPoints,
    ) -> impl Iterator<Item = Self> + 'a {
        points.shares.iter().map(move |(cell, share)| {
            let [along_m, across_m] = cell.map(|it| Fixed(f64::from(it) * CELL_M));
            Self {
                data: data.to_owned(),
                simulated: is_simulated,
                class: points.class,
                frame: points.frame.to_owned(),
                vehicles: points.n_vehicles,
                along_m,
                across_m,
                share: Fixed(*share),
            }
        })
    }
}

row! {
    /// A median or a share over a slice.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct BoxErrorRow {
        data: String,
        simulated: bool,
        by: String,
        slice: String,
        error: String,
        unit: String,
        fit: String,
        n_pairs: u64,
        n_tracks: u64,
        value: Option<Fixed<4>>,
        low: Option<Fixed<4>>,
        high: Option<Fixed<4>>,
        blocks: BlockColumns = ["n_blocks", "blocks", "few_blocks"],
    }
}

impl BoxErrorRow {
    /// The rows of `line`, one for each fit.
    pub fn of(line: &BoxErrorLine) -> impl Iterator<Item = Self> + '_ {
        line.fits.iter().map(|(fit, number)| {
            let interval = number.and_then(|it| it.within);
            Self {
                data: line.data.clone(),
                simulated: line.is_simulated,
                by: line.by.clone(),
                slice: line.slice.clone(),
                error: line.error.name().to_owned(),
                unit: line.error.unit().to_owned(),
                fit: (*fit).to_owned(),
                n_pairs: line.n_pairs,
                n_tracks: line.n_tracks,
                value: number.map(|it| Fixed(it.value)),
                low: interval.map(|it| Fixed(it.ends[0])),
                high: interval.map(|it| Fixed(it.ends[1])),
                blocks: interval.map(|it| it.blocks).into(),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::tests::csv_text;
    use crate::numbers::box_errors::tests::lines;

    #[test]
    fn medians_of_nothing_are_left_empty() {
        let lines = [lines("street", "range", "0–15 m", 40), lines("street", "range", "50–80 m", 0)].concat();
        let rows: Vec<BoxErrorRow> = lines.iter().step_by(3).flat_map(BoxErrorRow::of).collect();
        insta::assert_snapshot!(csv_text(&rows), @r"
        data,simulated,by,slice,error,unit,fit,n_pairs,n_tracks,value,low,high,n_blocks,blocks,few_blocks
        street,true,range,0–15 m,centre,m,hull box,40,10,0.5000,0.4500,0.6000,10,tracks,false
        street,true,range,0–15 m,centre,m,PCA box,40,10,1.0000,0.9000,1.2000,10,tracks,false
        street,true,range,0–15 m,BEV IoU >= 0.7,%,hull box,40,10,0.5000,0.4500,0.6000,10,tracks,false
        street,true,range,0–15 m,BEV IoU >= 0.7,%,PCA box,40,10,1.0000,0.9000,1.2000,10,tracks,false
        street,true,range,50–80 m,yaw within 10 deg,%,hull box,0,0,,,,,,
        street,true,range,50–80 m,yaw within 10 deg,%,PCA box,0,0,,,,,,
        ");
    }
}
