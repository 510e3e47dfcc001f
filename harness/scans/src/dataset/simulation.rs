//! Record of a simulation that made scans.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// The request to a simulator, in its own words. Here it only tells that the scans are simulated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Simulation(Map<String, Value>);

impl Simulation {
    /// Keeps `asked_for`, which has named fields of finite numbers and text.
    pub fn of(asked_for: &impl Serialize) -> Self {
        // As text, so that a number of 32 bits is written with the digits that it has.
        let text = serde_json::to_string(asked_for).expect("fields with names are JSON");
        Self(serde_json::from_str(&text).expect("a struct is a JSON object"))
    }

    /// All text in it, such as the name of the sensor, and the names of its fields.
    pub fn texts(&self) -> Vec<&str> {
        let mut texts = Vec::new();
        let mut fields: Vec<(&String, &Value)> = self.0.iter().collect();
        while let Some((name, value)) = fields.pop() {
            texts.push(name.as_str());
            texts.extend(value.as_str());
            fields.extend(value.as_object().into_iter().flatten());
        }
        texts
    }

    /// The request, as a simulator of the kind `T` puts it.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, serde_json::Error> {
        serde_json::from_value(Value::Object(self.0.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Drive {
        rain_mm_per_h: f32,
        seed: u64,
        sensor: Option<String>,
    }

    #[test]
    fn what_was_asked_for_is_kept_to_the_bit() {
        let drive = Drive { rain_mm_per_h: 0.1, seed: u64::MAX, sensor: None };
        let kept = Simulation::of(&drive);
        let text = serde_json::to_string(&kept).unwrap();
        assert_eq!(text, r#"{"rain_mm_per_h":0.1,"seed":18446744073709551615,"sensor":null}"#);
        assert_eq!(serde_json::from_str::<Simulation>(&text).unwrap(), kept);
        assert_eq!(kept.read::<Drive>().unwrap(), drive);
    }

    #[test]
    fn text_is_found_wherever_it_is() {
        let simulation: Simulation =
            serde_json::from_str(r#"{"seed":5,"sensor":"vlp-16","conditions":{"name":"wet"}}"#).unwrap();
        let mut texts = simulation.texts();
        texts.sort_unstable();
        assert_eq!(texts, ["conditions", "name", "seed", "sensor", "vlp-16", "wet"]);
    }

    #[test]
    fn another_simulation_is_not_taken_for_it() {
        #[derive(Serialize)]
        struct Town {
            town: u32,
        }
        let error = Simulation::of(&Town { town: 5 }).read::<Drive>().expect_err("another");
        assert!(error.to_string().contains("unknown field `town`"), "{error}");
    }
}
