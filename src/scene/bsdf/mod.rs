//! Window elements measured or computed as a BSDF: how much light goes from each patch of directions to each other one.
//!
//! In: a file in the XML of LBNL's WINDOW. Out: [`Bsdf`]. Azimuths are those of the light's way, not of its source: what goes
//! straight through stays in its patch, and so does what a mirror reflects. Front is the file's front.

mod klems;
mod xml;

pub use klems::{KlemsBasis, Patch, PatchFinder};

use std::f64::consts::PI;

/// From which side to which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passage {
    /// Arrives on the front, leaves the back.
    TransmissionFront,
    /// Arrives on the back, leaves the front.
    TransmissionBack,
    /// Arrives on the front and leaves it.
    ReflectionFront,
    /// Arrives on the back and leaves it.
    ReflectionBack,
}

impl Passage {
    /// All four.
    pub const ALL: [Self; 4] =
        [Self::TransmissionFront, Self::TransmissionBack, Self::ReflectionFront, Self::ReflectionBack];

    /// The name in a file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::TransmissionFront => "Transmission Front",
            Self::TransmissionBack => "Transmission Back",
            Self::ReflectionFront => "Reflection Front",
            Self::ReflectionBack => "Reflection Back",
        }
    }
}

/// Bidirectional scattering between the patches of two bases, sr⁻¹.
#[derive(Clone, Debug, PartialEq)]
pub struct Scattering {
    /// Patches in which light arrives.
    pub incident: KlemsBasis,
    /// Patches in which it leaves.
    pub outgoing: KlemsBasis,
    /// `[outgoing][incident]`.
    values: Vec<f64>,
}

impl Scattering {
    /// Radiance that leaves in a patch, per irradiance that arrives in another one, sr⁻¹.
    #[must_use]
    pub fn value(&self, outgoing: usize, incident: usize) -> f64 {
        self.values[outgoing * self.incident.patches().len() + incident]
    }

    /// The same light the other way (Helmholtz): azimuths are those of the light's way, so each turns by half a turn.
    fn reversed(&self) -> Self {
        let (rows, columns) = (self.outgoing.patches().len(), self.incident.patches().len());
        let (leaving, arriving) = (PatchFinder::new(self.outgoing), PatchFinder::new(self.incident));
        let value = |o: usize, i: usize| self.values[leaving.opposite(o) * columns + arriving.opposite(i)];
        let values = (0..columns).flat_map(|i| (0..rows).map(move |o| value(o, i))).collect();
        Self { incident: self.outgoing, outgoing: self.incident, values }
    }

    /// A share of it, as dirt leaves.
    fn scale(&mut self, share: f64) {
        self.values.iter_mut().for_each(|v| *v *= share);
    }

    /// Share that leaves of what arrives in each patch: `Σ_o f(o, i) Ω_o`, Ω the projected solid angles.
    #[must_use]
    pub fn directional_hemispherical(&self) -> Vec<f64> {
        let (outgoing, columns) = (self.outgoing.patches(), self.incident.patches().len());
        let share = |i: usize| {
            let leaving =
                outgoing.iter().enumerate().map(|(o, p)| self.values[o * columns + i] * p.projected_solid_angle());
            leaving.sum()
        };
        (0..columns).map(share).collect()
    }

    /// Share that leaves of what arrives from all directions alike.
    #[must_use]
    pub fn hemispherical(&self) -> f64 {
        let shares = self.directional_hemispherical();
        self.incident.patches().iter().zip(&shares).map(|(p, s)| p.projected_solid_angle() * s).sum::<f64>() / PI
    }
}

/// A window element.
#[derive(Clone, Debug)]
pub struct Bsdf {
    /// By [`Passage`], in the order of [`Passage::ALL`]; what a file does not tell is none.
    scattering: [Option<Scattering>; 4],
}

impl Bsdf {
    /// Passes but a share of what it passed, either way.
    #[must_use]
    pub fn dimmed(mut self, share: f64) -> Self {
        for passage in [Passage::TransmissionFront, Passage::TransmissionBack] {
            if let Some(scattering) = &mut self.scattering[passage as usize] {
                scattering.scale(share);
            }
        }
        self
    }

    /// What goes one way; nothing does where there is none.
    #[must_use]
    pub fn scattering(&self, passage: Passage) -> Option<&Scattering> {
        self.scattering[passage as usize].as_ref()
    }
}
