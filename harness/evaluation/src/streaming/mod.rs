//! What detections are worth when the world has moved on: the newest answer that exists, judged at every moment of a drive.
//!
//! All of it is made of the rows of a run: nothing is detected again. Reference: Li, Wang, Ramanan, *Towards streaming
//! perception*, ECCV 2020, for boxes in the image; here boxes are in space, and move with the car.

pub mod moving;
pub mod logged_drive;
pub mod truth;
pub mod schedule;
pub mod tracker;
pub mod forecast;
pub mod judgement;
pub mod latencies;
pub mod stream_study;
pub mod stream_picture;
