//! Tests of the hierarchical detector as a whole, on a drawn street.

mod drawn_street;
mod drawn_vehicles;
mod nu_svc;
mod stage_products;
mod steady_state;
