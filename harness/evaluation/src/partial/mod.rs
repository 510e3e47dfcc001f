//! What objects are told to be of which only a part has been seen: the ten-step experiment, its rivals, and what each part of
//! the method is worth.

pub mod object_parts;
pub mod model_training;
pub mod rival_values;
pub mod pairwise_svm;
pub mod methods;
pub mod experiment;
pub mod growth;
