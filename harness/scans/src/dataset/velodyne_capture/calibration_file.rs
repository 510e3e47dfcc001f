//! The calibration of one sensor: the maker's `db.xml`, or the YAML that other people's drivers make of it.

use std::collections::BTreeMap;

use quick_xml::Reader;
use quick_xml::events::Event;

use super::laser_table::Laser;

/// No sensor has more lasers.
const MAX_LASERS: usize = 128;

/// Metres of a step of the distances in packets; files with other steps belong to other sensors.
pub const DISTANCE_STEP_M: f32 = 0.002;

/// Numbers beyond this are mistakes, whatever the unit.
const MAX_MAGNITUDE: f32 = 1e4;

/// The values of a laser by their names in YAML, in metres and radians.
type Values = BTreeMap<&'static str, f32>;

/// The lasers in `text` by their numbers, from 0. Errors are the rest of a sentence about the file.
pub fn parse_calibration_file(text: &str) -> Result<Vec<Laser>, String> {
    let listed = if text.trim_start().starts_with('<') { parse_xml(text)? } else { parse_yaml(text)? };
    let mut lasers = BTreeMap::new();
    for values in &listed {
        let id = values.get("laser_id").copied().filter(|it| *it >= 0.0 && it.fract() == 0.0);
        let id = id.ok_or("has a laser without a number")? as usize;
        if lasers.insert(id, laser_of(values)).is_some() {
            return Err(format!("has the laser {id} twice"));
        }
    }
    match lasers.keys().copied().enumerate().find(|(index, id)| index != id) {
        Some((missing, _)) => Err(format!("has no laser {missing}")),
        None if lasers.is_empty() => Err("has no lasers".to_owned()),
        None => Ok(lasers.into_values().collect()),
    }
}

fn laser_of(values: &Values) -> Laser {
    let value = |name: &str| values.get(name).copied().unwrap_or(0.0);
    let nearby = [value("dist_correction_x"), value("dist_correction_y")];
    Laser {
        vertical_rad: value("vert_correction"),
        rotation_rad: value("rot_correction"),
        vertical_offset_m: value("vert_offset_correction"),
        horizontal_offset_m: value("horiz_offset_correction"),
        distance_m: value("dist_correction"),
        // Sensors that were measured at one distance only have zeros here.
        distance_nearby_m: (nearby != [0.0; 2]).then_some(nearby),
    }
}

/// The values that are used: name in YAML, name in XML, and the factor from XML to metres and radians.
const DEGREES: f32 = std::f32::consts::PI / 180.0;
const CENTIMETRES: f32 = 0.01;
const NAMES: [(&str, &str, f32); 8] = [
    ("laser_id", "id_", 1.0),
    ("rot_correction", "rotCorrection_", DEGREES),
    ("vert_correction", "vertCorrection_", DEGREES),
    ("dist_correction", "distCorrection_", CENTIMETRES),
    ("dist_correction_x", "distCorrectionX_", CENTIMETRES),
    ("dist_correction_y", "distCorrectionY_", CENTIMETRES),
    ("vert_offset_correction", "vertOffsetCorrection_", CENTIMETRES),
    ("horiz_offset_correction", "horizOffsetCorrection_", CENTIMETRES),
];

fn number(name: &str, text: &str) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(number) if number.abs() <= MAX_MAGNITUDE => Ok(number),
        _ => Err(format!("has {:?} as {name}", text.trim().chars().take(40).collect::<String>())),
    }
}

fn check_step(step_m: f32) -> Result<(), String> {
    if (step_m - DISTANCE_STEP_M).abs() < 1e-6 {
        return Ok(());
    }
    Err(format!("has distances in steps of {step_m} m; only {DISTANCE_STEP_M} is supported"))
}

fn begin_laser(lasers: &mut Vec<Values>) -> Result<(), String> {
    lasers.push(Values::new());
    if lasers.len() > MAX_LASERS { Err(format!("has more than {MAX_LASERS} lasers")) } else { Ok(()) }
}

/// A list of items with names and numbers, in lines or between braces. Only the part of YAML that these files use.
fn parse_yaml(text: &str) -> Result<Vec<Values>, String> {
    let mut lasers: Vec<Values> = Vec::new();
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or_default().trim();
        let begins = line == "-" || line.starts_with("- ");
        if begins {
            begin_laser(&mut lasers)?;
        }
        for pair in line.trim_start_matches("- ").split([',', '{', '}']) {
            let Some((name, value)) = pair.split_once(':') else { continue };
            let name = name.trim();
            if name == "distance_resolution" {
                check_step(number(name, value)?)?;
            }
            let known = NAMES.iter().find(|(known, ..)| *known == name);
            if let (Some((name, ..)), Some(laser)) = (known, lasers.last_mut()) {
                laser.insert(name, number(name, value)?);
            }
        }
    }
    Ok(lasers)
}

/// Boost's XML: an element `px` for every laser.
fn parse_xml(text: &str) -> Result<Vec<Values>, String> {
    let mut reader = Reader::from_str(text);
    let (mut lasers, mut content, mut is_in_laser): (Vec<Values>, _, _) = (Vec::new(), String::new(), false);
    loop {
        match reader.read_event().map_err(|error| format!("is not XML: {error}"))? {
            Event::Start(element) => {
                content.clear();
                if element.name().as_ref() == b"px" {
                    is_in_laser = true;
                    begin_laser(&mut lasers)?;
                }
            }
            Event::Text(text) => {
                content.push_str(&text.decode().map_err(|error| format!("has damaged text: {error}"))?);
            }
            Event::End(element) => {
                let name = element.name();
                if name.as_ref() == b"px" {
                    is_in_laser = false;
                }
                if name.as_ref() == b"distLSB_" {
                    check_step(number("distLSB_", &content)? * CENTIMETRES)?;
                }
                let known = NAMES.iter().find(|(_, known, _)| known.as_bytes() == name.as_ref());
                if let (Some((name, written, unit)), Some(laser), true) =
                    (known, lasers.last_mut(), is_in_laser)
                {
                    laser.insert(name, number(written, &content)? * unit);
                }
            }
            Event::DocType(content) if content.contains(&b'[') || content.contains(&b'"') => {
                return Err("has a document type with definitions, which are not read".to_owned());
            }
            Event::GeneralRef(_) => return Err("has a reference to an entity, which is not read".to_owned()),
            Event::Eof => return Ok(lasers),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLOCKS: &str = "# of a sensor\ndistance_resolution: 0.002\nlasers:\n- dist_correction: 1.2\n  \
        dist_correction_x: 1.3\n  dist_correction_y: 1.25\n  laser_id: 1\n  rot_correction: 0.05\n  vert_correction: -0.1\n\
        - laser_id: 0\n  vert_offset_correction: 0.2\nnum_lasers: 2\n";

    #[test]
    fn the_same_is_read_from_lines_braces_and_xml() {
        let braces = "lasers:\n- {dist_correction: 1.2, dist_correction_x: 1.3, dist_correction_y: 1.25, laser_id: 1,\n  \
            rot_correction: 0.05, vert_correction: -0.1}\n- {laser_id: 0, vert_offset_correction: 0.2}\n";
        let degrees = |rad: f32| rad.to_degrees();
        let xml = format!(
            "<?xml version=\"1.0\"?><!DOCTYPE boost_serialization><boost_serialization><DB><distLSB_>0.2</distLSB_>\
             <points_><item><px><id_>1</id_><rotCorrection_>{}</rotCorrection_><vertCorrection_>{}</vertCorrection_>\
             <distCorrection_>120</distCorrection_><distCorrectionX_>130</distCorrectionX_>\
             <distCorrectionY_>125</distCorrectionY_></px></item><item><px><id_>0</id_>\
             <vertOffsetCorrection_>20</vertOffsetCorrection_></px></item></points_></DB></boost_serialization>",
            degrees(0.05),
            degrees(-0.1)
        );
        let expected = parse_calibration_file(BLOCKS).unwrap();
        assert_eq!(expected.len(), 2);
        assert_eq!(expected[0].vertical_offset_m, 0.2);
        assert_eq!(expected[1].distance_nearby_m, Some([1.3, 1.25]));
        assert_eq!(parse_calibration_file(braces).unwrap(), expected);
        for (found, expected) in parse_calibration_file(&xml).unwrap().iter().zip(&expected) {
            assert!((found.vertical_rad - expected.vertical_rad).abs() < 1e-6);
            assert!((found.distance_m - expected.distance_m).abs() < 1e-6);
        }
    }

    #[test]
    fn what_is_damaged_is_refused() {
        let refused = |text: &str, part: &str| {
            let problem = parse_calibration_file(text).expect_err("damaged");
            assert!(problem.contains(part), "{problem}");
        };
        refused("", "has no lasers");
        refused(&BLOCKS.replace("laser_id: 0", "laser_id: 1"), "has the laser 1 twice");
        refused(&BLOCKS.replace("laser_id: 0", "laser_id: 2"), "has no laser 0");
        refused(&BLOCKS.replace("laser_id: 0", "laser_id: x"), "\"x\" as laser_id");
        refused(&BLOCKS.replace("0.002", "0.004"), "steps of 0.004 m");
        refused(&"- laser_id: 0\n".repeat(1000), "more than 128");
        refused("<!DOCTYPE a [<!ENTITY b \"c\">]><a>&b;</a>", "definitions");
    }
}
