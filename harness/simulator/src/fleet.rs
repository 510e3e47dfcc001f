//! Vehicles of a place and their shares: files in `fleets/`.

use std::sync::LazyLock;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

use super::body_style::BodyStyle;
use super::car_shape::car_of_style;
use super::object_shape::ObjectShape;
use super::vehicle_shape::{BusStyle, TruckStyle, VanStyle, bus, truck, van};

/// Vehicles of a place and their shares.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fleet {
    /// Cars, vans, trucks and buses among a hundred vehicles that drive or wait.
    driven: [u32; 4],
    /// Cars, vans, trucks and buses among a hundred vehicles that are parked along streets.
    parked: [u32; 4],
    /// Extra width of lanes for parking along kerbs, beyond the drawn width, in metres.
    pub parking_room_m: f32,
    #[serde(default)]
    cars: Vec<BodyStyle>,
    #[serde(default)]
    vans: Vec<VanStyle>,
    #[serde(default)]
    trucks: Vec<TruckStyle>,
    #[serde(default)]
    buses: Vec<BusStyle>,
}

/// A European town.
pub static TOWN: LazyLock<Fleet> = LazyLock::new(|| parsed(include_str!("fleets/town.toml")));
/// A place where goods are handled.
pub static HAULAGE: LazyLock<Fleet> =
    LazyLock::new(|| parsed(include_str!("fleets/haulage.toml")).filled_up());
/// A North American town.
pub static NORTH_AMERICAN: LazyLock<Fleet> =
    LazyLock::new(|| parsed(include_str!("fleets/north_american.toml")).filled_up());
/// Vehicles of many places.
pub static VARIED: LazyLock<Fleet> = LazyLock::new(|| parsed(include_str!("fleets/varied.toml")));

fn parsed(text: &str) -> Fleet {
    toml::from_str(text).expect("every file is read by a test")
}

impl Fleet {
    /// The fleet with the vehicles of a European town for all kinds that it has none of.
    fn filled_up(self) -> Self {
        fn unless_empty<T: Clone>(own: Vec<T>, of_town: &[T]) -> Vec<T> {
            if own.is_empty() { of_town.to_vec() } else { own }
        }
        let Self { cars, vans, trucks, buses, .. } = &*TOWN;
        Self {
            cars: unless_empty(self.cars, cars),
            vans: unless_empty(self.vans, vans),
            trucks: unless_empty(self.trucks, trucks),
            buses: unless_empty(self.buses, buses),
            ..self
        }
    }

    /// Draws a vehicle that drives or waits.
    pub fn driven(&self, rng: &mut ChaCha8Rng) -> ObjectShape {
        self.one_of(self.driven, rng)
    }

    /// Draws a vehicle that is parked along a street.
    pub fn parked(&self, rng: &mut ChaCha8Rng) -> ObjectShape {
        self.one_of(self.parked, rng)
    }

    /// Draws a car.
    pub fn car(&self, rng: &mut ChaCha8Rng) -> ObjectShape {
        car_of_style(any(&self.cars, |it| it.percent, rng), rng)
    }

    /// Draws a truck of this height in metres.
    pub fn truck_of_height(&self, height_m: f32, rng: &mut ChaCha8Rng) -> ObjectShape {
        truck(any(&self.trucks, |it| it.percent, rng), Some(height_m), rng)
    }

    fn one_of(&self, [cars, vans, trucks, _]: [u32; 4], rng: &mut ChaCha8Rng) -> ObjectShape {
        match rng.random_range(0..100_u32) {
            it if it < cars => self.car(rng),
            it if it < cars + vans => van(any(&self.vans, |it| it.percent, rng), rng),
            it if it < cars + vans + trucks => truck(any(&self.trucks, |it| it.percent, rng), None, rng),
            _ => bus(any(&self.buses, |it| it.percent, rng), rng),
        }
    }
}

/// Draws one of `styles` by their shares. A single style takes no random number.
fn any<'a, T>(styles: &'a [T], percent: impl Fn(&T) -> u32, rng: &mut ChaCha8Rng) -> &'a T {
    let [only] = styles else {
        let mut drawn = rng.random_range(0..styles.iter().map(&percent).sum::<u32>());
        let is_drawn = |style: &&T| {
            let is_it = drawn < percent(style);
            drawn = drawn.saturating_sub(percent(style));
            is_it
        };
        return styles.iter().find(is_drawn).unwrap_or(&styles[0]);
    };
    only
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use reports::vocabulary::class::AnnotationClass;

    fn fleets() -> [&'static Fleet; 4] {
        [&TOWN, &HAULAGE, &NORTH_AMERICAN, &VARIED]
    }

    #[test]
    fn shares_add_up_to_a_hundred_and_every_kind_has_styles() {
        for it in fleets() {
            assert_eq!([it.driven, it.parked].map(|it| it.iter().sum::<u32>()), [100, 100]);
            assert!(![it.cars.len(), it.vans.len(), it.trucks.len(), it.buses.len()].contains(&0));
        }
        assert_eq!(TOWN.cars.iter().map(|it| it.percent).sum::<u32>(), 100);
    }

    #[test]
    fn vehicles_are_as_often_seen_as_said() {
        let shares = |draw: &dyn Fn(&mut ChaCha8Rng) -> ObjectShape| {
            let mut rng = ChaCha8Rng::from_seed([3; 32]);
            let classes: Vec<_> = (0..2000).map(|_| draw(&mut rng).class).collect();
            [AnnotationClass::Car, AnnotationClass::Van, AnnotationClass::Truck, AnnotationClass::Bus]
                .map(|class| classes.iter().filter(|&&it| it == class).count() as f32 / 20.0)
        };
        for fleet in fleets() {
            for (found, said) in [
                (shares(&|it| fleet.driven(it)), fleet.driven),
                (shares(&|it| fleet.parked(it)), fleet.parked),
            ] {
                for (found, said) in found.into_iter().zip(said) {
                    assert!(
                        (found - said as f32).abs() < 3.5 && (found > 0.0) == (said > 0),
                        "{found} of {said}"
                    );
                }
            }
        }
    }
}
