//! Tests of the whole: the structure of the code, and the program from outside.

mod layers;
