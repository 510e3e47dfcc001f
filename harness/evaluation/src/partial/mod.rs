//! How partly seen objects are classified: the ten-step experiment, the rivals, and what each part of the method
//! contributes.

pub mod object_parts;
pub mod model_training;
pub mod rival_values;
pub mod pairwise_svm;
pub mod methods;
pub mod experiment;
pub mod growth;
