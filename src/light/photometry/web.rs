//! A luminous intensity distribution: candelas on a web of two angles, bilinear between them.
//!
//! Local axes: nadir (the aim) is −z, plane C0 holds +x, plane C90 +y. Type C has its poles at nadir and zenith:
//! `γ` from nadir, `C` from +x towards +y. Types A and B have their poles at vertical ±90°: the direction (0, 0) is −z,
//! vertical angles rise towards +x, horizontal ones towards −y.

use std::f64::consts::TAU;

use glam::DVec3;

use super::numbers::{LARGEST, rising};
use crate::{Error, Result};

/// The axes of a goniophotometer (IES LM-63; CIE 121).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhotometricType {
    /// Vertical planes about the axis nadir-zenith: indoor and road luminaires.
    C,
    /// Floodlights.
    B,
    /// Motor-car lamps.
    A,
}

impl PhotometricType {
    /// "A", "B" or "C".
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::C => "C",
            Self::B => "B",
            Self::A => "A",
        }
    }
}

/// What part of the horizontal angles is stored, the rest being its mirror image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// One plane.
    Axial,
    /// 0 to 90 degrees.
    Quadrant,
    /// 0 to 180 degrees: mirrored in the plane 0-180 (types A and B: 0 to 90, mirrored at 0).
    Bilateral,
    /// 90 to 270 degrees: mirrored in the plane 90-270.
    Lateral,
    /// All planes.
    None,
}

impl Symmetry {
    /// What a user calls it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Axial => "axial",
            Self::Quadrant => "quadrant",
            Self::Bilateral => "bilateral 0-180",
            Self::Lateral => "bilateral 90-270",
            Self::None => "none",
        }
    }

    /// How often the stored part covers the whole.
    fn copies(self) -> f64 {
        match self {
            Self::Axial | Self::None => 1.0,
            Self::Bilateral | Self::Lateral => 2.0,
            Self::Quadrant => 4.0,
        }
    }
}

/// Candelas on a web of angles.
#[derive(Clone, Debug, PartialEq)]
pub struct Web {
    kind: PhotometricType,
    symmetry: Symmetry,
    /// Vertical angles, degrees, increasing.
    vertical_deg: Vec<f64>,
    /// Horizontal angles, degrees, increasing; a full circle ends with a copy of its first plane at 360°.
    horizontal_deg: Vec<f64>,
    /// `[horizontal][vertical]`.
    candela: Vec<f64>,
}

/// Angles of a file may miss their round ends by rounding.
const SAME_DEG: f64 = 1e-6;

impl Web {
    /// A web of candelas, `[horizontal][vertical]`; the horizontal angles tell its symmetry.
    ///
    /// # Errors
    /// Angles that do not rise or leave their range, counts that do not agree, negative candelas.
    pub fn new(
        kind: PhotometricType,
        vertical_deg: Vec<f64>,
        horizontal_deg: Vec<f64>,
        candela: Vec<f64>,
    ) -> Result<Self> {
        let vertical_deg = rising(vertical_deg, "vertical angles")?;
        let horizontal_deg = rising(horizontal_deg, "horizontal angles")?;
        let lowest = if kind == PhotometricType::C { 0.0 } else { -90.0 };
        check_range(&vertical_deg, "vertical", (lowest, lowest + 180.0))?;
        if vertical_deg.len() < 2 || candela.len() != vertical_deg.len() * horizontal_deg.len() {
            return Err(Error::malformed(format!(
                "{} candelas for {} vertical and {} horizontal angles (of which there must be 2 and 1 at least)",
                candela.len(),
                vertical_deg.len(),
                horizontal_deg.len()
            )));
        }
        if let Some(k) = candela.iter().position(|i| !(0.0..=LARGEST).contains(i)) {
            return Err(Error::malformed(format!(
                "the intensity at vertical {}, horizontal {} degrees is {} cd",
                vertical_deg[k % vertical_deg.len()],
                horizontal_deg[k / vertical_deg.len()],
                candela[k]
            ))
            .mend(format!("intensities are zero to {LARGEST:e} cd: correct the value or the multipliers")));
        }
        let symmetry = symmetry(kind, &horizontal_deg)?;
        let mut web = Self { kind, symmetry, vertical_deg, horizontal_deg, candela };
        web.close();
        Ok(web)
    }

    /// A circle of planes is closed: it goes from 0° to 360°, where the same plane stands again. Where the list has none
    /// there, it is the one between the last and the first.
    fn close(&mut self) {
        if self.symmetry != Symmetry::None || self.kind != PhotometricType::C {
            return;
        }
        let (first_deg, last_deg) = (self.horizontal_deg[0], self.horizontal_deg[self.horizontal_deg.len() - 1]);
        let (starts, ends) = (first_deg < SAME_DEG, last_deg > 360.0 - SAME_DEG);
        let first = self.plane(0);
        let seam: Vec<f64> = if starts {
            first.to_vec()
        } else {
            let t = (360.0 - last_deg) / (360.0 + first_deg - last_deg);
            self.plane(self.horizontal_deg.len() - 1).iter().zip(first).map(|(a, b)| lerp(*a, *b, t)).collect()
        };
        if !starts {
            self.horizontal_deg.insert(0, 0.0);
            self.candela.splice(0..0, seam.iter().copied());
        }
        if !ends {
            self.horizontal_deg.push(360.0);
            self.candela.extend(seam);
        }
    }

    /// The goniophotometer's axes.
    #[must_use]
    pub fn kind(&self) -> PhotometricType {
        self.kind
    }

    /// What part is stored.
    #[must_use]
    pub fn symmetry(&self) -> Symmetry {
        self.symmetry
    }

    /// Vertical angles, degrees.
    #[must_use]
    pub fn vertical_deg(&self) -> &[f64] {
        &self.vertical_deg
    }

    /// Horizontal angles, degrees.
    #[must_use]
    pub fn horizontal_deg(&self) -> &[f64] {
        &self.horizontal_deg
    }

    /// The candelas of one plane.
    #[must_use]
    pub fn plane(&self, number: usize) -> &[f64] {
        let n = self.vertical_deg.len();
        &self.candela[number * n..(number + 1) * n]
    }

    /// The same with every candela times a factor.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.candela.iter_mut().for_each(|i| *i *= factor);
        self
    }

    /// Largest intensity, cd, with its vertical and horizontal angle in degrees.
    #[must_use]
    pub fn peak(&self) -> (f64, f64, f64) {
        let mut peak = (0.0, self.vertical_deg[0], self.horizontal_deg[0]);
        for (k, candela) in self.candela.iter().enumerate() {
            if *candela > peak.0 {
                let n = self.vertical_deg.len();
                peak = (*candela, self.vertical_deg[k % n], self.horizontal_deg[k / n]);
            }
        }
        peak
    }

    /// Intensity, cd, in a direction given in the luminaire's own axes, of any length.
    #[must_use]
    pub fn towards(&self, d: DVec3) -> f64 {
        let (vertical, horizontal) = match self.kind {
            PhotometricType::C => (
                (d.x * d.x + d.y * d.y).sqrt().atan2(-d.z),
                if self.symmetry == Symmetry::Axial { 0.0 } else { d.y.atan2(d.x) },
            ),
            PhotometricType::A | PhotometricType::B => (d.x.atan2((d.y * d.y + d.z * d.z).sqrt()), (-d.y).atan2(-d.z)),
        };
        self.at(vertical.to_degrees(), horizontal.to_degrees())
    }

    /// The unit vector, in the luminaire's own axes, of a vertical and a horizontal angle in degrees.
    #[must_use]
    pub fn direction(&self, vertical_deg: f64, horizontal_deg: f64) -> DVec3 {
        let ((sv, cv), (sh, ch)) = (vertical_deg.to_radians().sin_cos(), horizontal_deg.to_radians().sin_cos());
        match self.kind {
            PhotometricType::C => DVec3::new(sv * ch, sv * sh, -cv),
            PhotometricType::A | PhotometricType::B => DVec3::new(sv, -cv * sh, -cv * ch),
        }
    }

    /// Intensity, cd, at a vertical and a horizontal angle in degrees: bilinear, zero outside the vertical range.
    #[must_use]
    pub fn at(&self, vertical_deg: f64, horizontal_deg: f64) -> f64 {
        let Some((v, s)) = place(&self.vertical_deg, vertical_deg) else { return 0.0 };
        if self.symmetry == Symmetry::Axial {
            return lerp(self.candela[v], self.candela[v + 1], s);
        }
        let Some((h, t)) = place(&self.horizontal_deg, self.fold(horizontal_deg)) else { return 0.0 };
        let (left, right) = (self.plane(h), self.plane(h + 1));
        lerp(lerp(left[v], left[v + 1], s), lerp(right[v], right[v + 1], s), t)
    }

    /// A horizontal angle in the part that is stored.
    fn fold(&self, degrees: f64) -> f64 {
        if self.kind != PhotometricType::C {
            let turned = (degrees + 180.0).rem_euclid(360.0) - 180.0;
            return if self.symmetry == Symmetry::Bilateral { turned.abs() } else { turned };
        }
        let circle = degrees.rem_euclid(360.0);
        let half = if circle > 180.0 { 360.0 - circle } else { circle };
        match self.symmetry {
            Symmetry::Axial => self.horizontal_deg[0],
            Symmetry::Bilateral => half,
            Symmetry::Quadrant if half > 90.0 => 180.0 - half,
            Symmetry::Quadrant => half,
            Symmetry::Lateral if circle < 90.0 => 180.0 - circle,
            Symmetry::Lateral if circle > 270.0 => 540.0 - circle,
            Symmetry::Lateral => circle,
            Symmetry::None => circle,
        }
    }

    /// Luminous flux, lm: the integral of the intensity, exact for the bilinear interpolation.
    #[must_use]
    pub fn flux_lm(&self) -> f64 {
        self.zone_flux_lm(f64::NEG_INFINITY, f64::INFINITY)
    }

    /// Luminous flux between two vertical angles, lm.
    #[must_use]
    pub fn zone_flux_lm(&self, from_deg: f64, to_deg: f64) -> f64 {
        let plane = |h: usize| self.plane_integral(self.plane(h), from_deg, to_deg);
        if self.symmetry == Symmetry::Axial {
            return TAU * plane(0);
        }
        let stored: f64 = (1..self.horizontal_deg.len())
            .map(|h| {
                let width = (self.horizontal_deg[h] - self.horizontal_deg[h - 1]).to_radians();
                0.5 * width * (plane(h - 1) + plane(h))
            })
            .sum();
        self.symmetry.copies() * stored
    }

    /// `∫ I sin γ dγ` (type C) or `∫ I cos V dV` (A and B) of a plane, piecewise linear in the angle.
    fn plane_integral(&self, candela: &[f64], from_deg: f64, to_deg: f64) -> f64 {
        // With the pole at zero both are a sine: V = γ − 90°.
        let shift = if self.kind == PhotometricType::C { 0.0 } else { 90.0 };
        let mut sum = 0.0;
        for (angles, values) in self.vertical_deg.windows(2).zip(candela.windows(2)) {
            let (from, to) = (angles[0].max(from_deg), angles[1].min(to_deg));
            if to <= from {
                continue;
            }
            let slope = (values[1] - values[0]) / (angles[1] - angles[0]).to_radians();
            let value = |angle: f64| values[0] + slope * (angle - angles[0]).to_radians();
            let (a, b) = ((from + shift).to_radians(), (to + shift).to_radians());
            sum += value(from) * a.cos() - value(to) * b.cos() + slope * (b.sin() - a.sin());
        }
        sum
    }
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// Interval of a rising list that holds `x`, and where in it; a single entry holds all.
fn place(list: &[f64], x: f64) -> Option<(usize, f64)> {
    let last = list.len() - 1;
    if x < list[0] - SAME_DEG || x > list[last] + SAME_DEG {
        return None;
    }
    // In most lists the angles stand at even steps; where they do not, a search tells.
    let guess = ((x - list[0]) / (list[last] - list[0]) * last as f64) as usize;
    let k = guess.min(last - 1);
    let holds = list[k] <= x && x < list[k + 1];
    let k = if holds { k } else { list.partition_point(|a| *a <= x).clamp(1, last) - 1 };
    Some((k, ((x - list[k]) / (list[k + 1] - list[k])).clamp(0.0, 1.0)))
}

fn check_range(angles_deg: &[f64], which: &str, (low, high): (f64, f64)) -> Result<()> {
    match angles_deg.iter().find(|a| **a < low - SAME_DEG || **a > high + SAME_DEG) {
        None => Ok(()),
        Some(a) => Err(Error::malformed(format!("{which} angle {a} is not within {low} to {high} degrees"))
            .mend("correct the angle, or the photometric type")),
    }
}

/// The symmetry that a list of horizontal angles says (LM-63).
fn symmetry(kind: PhotometricType, horizontal_deg: &[f64]) -> Result<Symmetry> {
    let (first, last) = match horizontal_deg {
        [] => return Err(Error::malformed("there is no horizontal angle").mend("give one plane at least")),
        [_] if kind == PhotometricType::C => return Ok(Symmetry::Axial),
        [first, .., last] => (*first, *last),
        [only] => (*only, *only),
    };
    let is = |a: f64, b: f64| (a - b).abs() < SAME_DEG;
    if kind != PhotometricType::C {
        check_range(horizontal_deg, "horizontal", (-180.0, 180.0))?;
        return match first {
            _ if horizontal_deg.len() < 2 => {
                Err(Error::malformed("types A and B need two horizontal angles at least").mend("add planes"))
            }
            f if is(f, 0.0) => Ok(Symmetry::Bilateral),
            _ => Ok(Symmetry::None),
        };
    }
    check_range(horizontal_deg, "horizontal", (0.0, 360.0))?;
    // What lacks its last plane goes round: 0, 15, ... 345.
    let step = horizontal_deg[horizontal_deg.len() - 1] - horizontal_deg[horizontal_deg.len() - 2];
    match (first, last) {
        (f, l) if is(f, 0.0) && is(l, 90.0) => Ok(Symmetry::Quadrant),
        (f, l) if is(f, 0.0) && is(l, 180.0) => Ok(Symmetry::Bilateral),
        (f, l) if is(f, 90.0) && is(l, 270.0) => Ok(Symmetry::Lateral),
        (f, l) if l - f >= 360.0 - SAME_DEG || (l > 180.0 && l + 1.5 * step >= 360.0 + f) => Ok(Symmetry::None),
        (f, l) => Err(Error::malformed(format!("horizontal angles from {f} to {l} degrees leave a gap"))
            .mend("they end at 0, 90, 180 or 360, or go from 90 to 270")),
    }
}
