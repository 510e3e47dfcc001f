//! Classification of partly seen objects: the ten-step experiment, the rivals, and the contribution of each part of the
//! method.

pub mod object_parts;
pub mod model_training;
pub mod rival_values;
pub mod pairwise_svm;
pub mod methods;
pub mod experiment;
pub mod growth;
