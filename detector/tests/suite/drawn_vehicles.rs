//! The embedded prototypes are those that the example writes.

use detector::describe::prototype_library::PrototypeLibrary;

#[path = "../../examples/drawn_vehicles.rs"]
#[expect(dead_code, reason = "the example has a main")]
mod example;

#[test]
fn the_embedded_prototypes_are_those_that_are_drawn() {
    assert_eq!(PrototypeLibrary::drawn(), example::drawn_vehicles().unwrap());
}
