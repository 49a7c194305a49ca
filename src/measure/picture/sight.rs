//! What a pixel's ray meets, and the light that leaves there towards the eye.

use glam::DVec3;

use crate::transport::caster::{MISS, Ray};
use crate::transport::{Fork, Landing, Optics, PANEL_SETS, SUN, Scatterer, Tint, World, follow};

/// What a pixel's ray meets, along one branch of its chain; for sky and ground the surface is [`MISS`], and `point` the
/// direction to them.
#[derive(Clone, Debug)]
pub(super) struct Sight {
    pub(super) surface: u32,
    pub(super) front: bool,
    pub(super) point: DVec3,
    pub(super) normal: DVec3,
    /// The far side of a translucent surface, whose light is seen from the near one.
    through: bool,
    /// By mirror or glass: its tint; plain sights carry none.
    pub(super) tint: Option<Vec<f32>>,
    /// A luminaire, which is no surface: its group and π times its luminance.
    glow: Option<(usize, f64)>,
}

/// Ways on through a window with a BSDF for what stands beyond.
const WAYS: u32 = 4;

/// Looks along a ray: one sight for a plain scene, one more for every pane on the way.
pub(super) fn look(world: &World, optics: &Optics, ray: Ray, sights: &mut Vec<Sight>) {
    sights.clear();
    let hit = world.caster.closest(&ray);
    let direction = DVec3::from_array(ray.direction.map(f64::from));
    if let Some(glow) = world.luminaire_seen(ray.at(0.0), direction, f64::from(hit.t)) {
        let (point, normal) = (direction, direction);
        sights.push(Sight { surface: MISS, front: true, point, normal, through: false, tint: None, glow: Some(glow) });
        return;
    }
    let mut tint = Tint::new(optics.pad);
    let mut panes = 0;
    for branch in (0..=8).rev() {
        // The highest branch goes straight through everything and tells how many panes there are.
        if branch < 8 && branch >= panes {
            continue;
        }
        tint.reset();
        let landing = follow(world, optics, ray, hit, Fork::Branch(branch), &mut tint, &mut 0);
        if branch == 8 {
            panes = tint.panes.min(8);
        }
        let coloured = tint.coloured || tint.scale != 1.0 || tint.panes > 0;
        let own_tint = || coloured.then(|| (0..optics.pad).map(|b| tint.share(b)).collect());
        if let Landing::Escaped { direction, .. } = landing
            && world.daylight().is_some()
        {
            let (point, normal) = (direction, direction);
            let (through, glow) = (false, None);
            sights.push(Sight { surface: MISS, front: true, point, normal, through, tint: own_tint(), glow });
        }
        if let Landing::Surface { surface, front, point, .. } = landing
            && let Some(scatterer) = world.scatterer(surface)
        {
            let window = WindowSide { scatterer, surface, front, point };
            window.look(world, optics, direction, &tint, sights);
        } else if let Landing::Surface { surface, front, point, .. } = landing {
            let s = &world.surfaces.list[surface as usize];
            for through in [false, true].into_iter().take(1 + usize::from(world.is_translucent(surface))) {
                let front = front != through;
                let normal = s.side_normal(front);
                let point = world.lift(s.point(s.uv(point)), normal);
                sights.push(Sight { surface, front, point, normal, through, tint: own_tint(), glow: None });
            }
        }
    }
}

/// A place on a window with a BSDF.
struct WindowSide<'a> {
    scatterer: &'a Scatterer,
    surface: u32,
    front: bool,
    point: DVec3,
}

impl WindowSide<'_> {
    /// What a window with a BSDF shows: its own surface, the daylight that it sends on, and by a few ways what stands beyond.
    fn look(&self, world: &World, optics: &Optics, direction: DVec3, before: &Tint, sights: &mut Vec<Sight>) {
        let (surface, front) = (self.surface, self.front);
        let s = &world.surfaces.list[surface as usize];
        let uv = s.uv(self.point);
        let passed = self.scatterer.passed(s, front, -direction) as f32;
        let left = |tint: &Tint, share: f32| Some((0..optics.pad).map(|b| share * tint.share(b)).collect());
        let normal = s.side_normal(front);
        let point = world.lift(s.point(uv), normal);
        let plain =
            Sight { surface, front, point, normal, through: false, tint: left(before, 1.0 - passed), glow: None };
        for set in 0..PANEL_SETS {
            let radiance = world.panels().radiance(world, (surface, front), set, uv, -direction);
            let share = left(before, 1.0 / PANEL_SETS as f32);
            sights.extend(radiance.iter().enumerate().filter(|(_, l)| **l > 0.0).map(|(group, l)| Sight {
                surface: MISS,
                tint: share.clone(),
                glow: Some((optics.lamps + group, std::f64::consts::PI * l)),
                ..plain.clone()
            }));
        }
        for way in 0..WAYS {
            let chance = (f64::from(way) + 0.5) / f64::from(WAYS);
            let on = self.scatterer.read_on(s, front, direction, chance);
            let ray = Ray::new(world.lift(s.point(uv), -normal), on);
            let mut tint = before.clone();
            let hit = world.caster.closest(&ray);
            let landing = follow(world, optics, ray, hit, Fork::Branch(u32::MAX), &mut tint, &mut 0);
            if let Landing::Surface { surface, front, point, .. } = landing {
                let s = &world.surfaces.list[surface as usize];
                let (normal, tint) = (s.side_normal(front), left(&tint, passed / WAYS as f32));
                let point = world.lift(s.point(s.uv(point)), normal);
                sights.push(Sight { surface, front, point, normal, through: false, tint, glow: None });
            }
        }
        sights.insert(0, plain);
    }
}

impl Sight {
    /// Share of what arrives that leaves towards the eye, and exitance of the surface itself.
    pub(super) fn leaving<'a>(&self, world: &World, optics: &'a Optics) -> (&'a [f32], Option<&'a Vec<f32>>) {
        let material = world.surfaces.list[self.surface as usize].material;
        if self.through {
            return (optics.tau(material), None);
        }
        let emitted = world.group(self.surface, self.front).map(|g| &optics.exitance[g]);
        (optics.rho(material, self.front), emitted)
    }
}

/// Radiance of sky, sun, ground or a luminaire as a sight shows it, added to `out` with a weight.
pub(super) fn add_background(world: &World, optics: &Optics, sight: &Sight, weight: f32, out: &mut [f32]) {
    let beyond = || {
        let sun = world.sun_disc(sight.point).map(|l| (optics.lamps + SUN, l));
        [world.background(sight.point), sun]
    };
    let seen = sight.glow.map_or_else(beyond, |glow| [Some(glow), None]);
    for (group, light) in seen.into_iter().flatten() {
        for (band, out) in out.iter_mut().enumerate() {
            let left = sight.tint.as_ref().map_or(1.0, |t| t[band]);
            *out += weight * left * optics.exitance[group][band] * light as f32 * std::f32::consts::FRAC_1_PI;
        }
    }
}
