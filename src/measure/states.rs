//! States of the lights: the lamps are divided into channels, each solved by itself in the same rows and read by the same
//! rays. Light is linear: a state is a level for each channel.

use crate::scene::{DAYLIGHT, ELECTRIC, LightState, Scene};
use crate::transport::{DAYLIGHT_GROUPS, World};

/// How the light of a scene is divided, and what is asked of the parts.
#[derive(Clone, Debug)]
pub(super) struct Channels {
    /// Channel of each group of light: emitting sides, luminaires, daylight.
    pub(super) of_group: Vec<usize>,
    /// States to report: those of the user, then daylight and electric light where there are both.
    pub(super) states: Vec<State>,
    /// The first of them are held to the tolerance: as many as the user named.
    pub(super) held: usize,
}

/// A state of the lights.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub(super) name: String,
    /// Level of each channel.
    pub(super) levels: Vec<f64>,
}

impl Channels {
    /// All light in one.
    pub(super) fn one(world: &World) -> Self {
        Self { of_group: vec![0; world.groups()], states: Vec::new(), held: 0 }
    }

    /// As few channels as the states of a scene need: groups that burn alike in all states share one.
    pub(super) fn new(scene: &Scene, world: &World) -> Self {
        let of_sides = world.emitters.materials.iter().map(|m| scene.materials[*m].emission.as_ref());
        let lamps: Vec<Option<&str>> = of_sides
            .map(|e| e.and_then(|e| e.group.as_deref()))
            .chain(world.emitters.dimming.iter().map(Option::as_deref))
            .collect();
        let days = if world.daylight().is_some() { DAYLIGHT_GROUPS } else { 0 };
        let parts = |name: &str, others: f64, daylight: bool| LightState {
            name: name.to_owned(),
            levels: Vec::new(),
            others,
            daylight,
        };
        let has_both = days > 0 && !lamps.is_empty();
        let split = has_both.then(|| [parts(DAYLIGHT, 0.0, true), parts(ELECTRIC, 1.0, false)]);
        let asked: Vec<LightState> = scene.states.iter().cloned().chain(split.into_iter().flatten()).collect();
        let of_lamp = |group: &Option<&str>| asked.iter().map(|s| s.level(*group)).collect::<Vec<f64>>();
        let of_day = || asked.iter().map(|s| f64::from(u8::from(s.daylight))).collect::<Vec<f64>>();
        let mut distinct: Vec<Vec<f64>> = Vec::new();
        let of_group = lamps
            .iter()
            .map(of_lamp)
            .chain((0..days).map(|_| of_day()))
            .map(|levels| {
                distinct.iter().position(|d| *d == levels).unwrap_or_else(|| {
                    distinct.push(levels);
                    distinct.len() - 1
                })
            })
            .collect();
        let states = asked
            .iter()
            .enumerate()
            .map(|(k, s)| State { name: s.name.clone(), levels: distinct.iter().map(|d| d[k]).collect() })
            .collect();
        Self { of_group, states, held: scene.states.len() }
    }
}
