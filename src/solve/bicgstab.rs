//! Stabilised bi-conjugate gradients (van der Vorst 1992) on `(I − SF) B = SD`, `S` the reflectances and transmittances, eight bands abreast.
//!
//! Sampled rows are not reciprocal, so the symmetric form is not open. One isolated eigenvalue goes to one with the
//! reflectance; a Krylov method takes it in a step or two, where sweeps need 1/(1 − ρ) of them.

use super::exchange::{Exchange, Way};
use crate::mesh::{Elements, NO_ELEMENT};
use crate::transport::{Optics, Rows, World};

/// Bands in a block.
pub const LANES: usize = 8;
type Lanes = [f64; LANES];
const MAX_STEPS: usize = 200;

/// One block of bands of one replica.
#[derive(Debug)]
pub struct Block<'a> {
    /// Geometry.
    pub world: &'a World,
    /// Materials.
    pub optics: &'a Optics,
    /// Elements.
    pub mesh: &'a Elements,
    /// Rows, for the direct light.
    pub rows: &'a Rows,
    /// Which replica.
    pub replica: usize,
    /// Its matrix.
    pub exchange: &'a Exchange,
    /// The matrix of another replica, whose rays tell what escapes: an element's own rays also made its radiosity, and
    /// the product of the two would count too little.
    pub other: &'a Exchange,
    /// Which block of eight bands.
    pub block: usize,
}

/// What came out of one block.
#[derive(Clone, Debug)]
pub struct BlockResult {
    /// Radiosity by element.
    pub radiosity: Vec<[f32; LANES]>,
    /// Flux absorbed by elements.
    pub absorbed: Lanes,
    /// Flux that left the scene after reflection.
    pub escaped: Lanes,
    /// Flux lost at mirrors and panes after reflection.
    pub lost: Lanes,
    /// Products with the matrix.
    pub products: usize,
    /// Largest relative residual of a band.
    pub residual: f64,
}

impl Block<'_> {
    /// Solves to a relative residual of `accuracy` in every band.
    #[must_use]
    pub fn solve(&self, accuracy: f64) -> BlockResult {
        let tints: Vec<Lanes> = self.rows.tints.iter().map(|t| self.lanes(t)).collect();
        let direct = self.direct(&tints);
        let scattering = self.scattering();
        let source: Vec<Lanes> = if self.world.glowing() {
            self.emitted()
        } else {
            let mut source = direct.clone();
            scattering.act(&mut source);
            source
        };
        let (radiosity, products, residual) = self.stabilised(&scattering, &source, &tints, accuracy);
        let mut result = BlockResult {
            radiosity: radiosity.iter().map(|b| b.map(|x| x as f32)).collect(),
            absorbed: [0.0; LANES],
            escaped: [0.0; LANES],
            lost: [0.0; LANES],
            products,
            residual,
        };
        self.account(&radiosity, &direct, &scattering, &tints, &mut result);
        result
    }

    /// What the elements do with light that arrives.
    fn scattering(&self) -> Scattering {
        let material = |e: &crate::mesh::Element| self.world.surfaces.list[e.surface as usize].material;
        let list = self.mesh.list();
        let twin = |(i, e): (usize, &crate::mesh::Element)| {
            let other = self.mesh.find(e.key.other_side());
            // Each pair once.
            let is_pair = self.world.is_translucent(e.surface) && other != NO_ELEMENT && i < other as usize;
            is_pair.then(|| (i, other as usize, self.lanes(self.optics.tau(material(e)))))
        };
        Scattering {
            rho: list.iter().map(|e| self.lanes(self.optics.rho(material(e), e.front))).collect(),
            pairs: list.iter().enumerate().filter_map(twin).collect(),
        }
    }

    /// Exitance of every element: the source where emission is not direct light.
    fn emitted(&self) -> Vec<Lanes> {
        let of = |e: &crate::mesh::Element| self.world.group(e.surface, e.front);
        let exitance = |e| of(e).map_or([0.0; LANES], |g| self.lanes(&self.optics.exitance[g]));
        self.mesh.list().iter().map(exitance).collect()
    }

    fn lanes(&self, bands: &[f32]) -> Lanes {
        std::array::from_fn(|l| f64::from(bands[self.block * LANES + l]))
    }

    /// Mean direct irradiance of every element.
    fn direct(&self, tints: &[Lanes]) -> Vec<Lanes> {
        let groups = self.rows.groups;
        let replica = &self.rows.replicas[self.replica];
        let exitance: Vec<Lanes> = self.optics.exitance.iter().map(|m| self.lanes(m)).collect();
        let mut direct: Vec<Lanes> = (0..self.mesh.len())
            .map(|i| {
                let mut d = [0.0; LANES];
                for (factor, m) in replica.direct[i * groups..(i + 1) * groups].iter().zip(&exitance) {
                    for l in 0..LANES {
                        d[l] += f64::from(*factor) * m[l];
                    }
                }
                d
            })
            .collect();
        for (i, irradiance) in &replica.tinted {
            let (d, irradiance) = (&mut direct[*i as usize], self.lanes(irradiance));
            *d = std::array::from_fn(|l| d[l] + irradiance[l]);
        }
        let per_ray = 1.0 / self.rows.rays as f64;
        for (i, group, weight, tint) in &replica.mirrored {
            let (d, m) = (&mut direct[*i as usize], &exitance[*group as usize]);
            for l in 0..LANES {
                d[l] += per_ray * f64::from(*weight) * tints[*tint as usize][l] * m[l];
            }
        }
        direct
    }

    /// `out = x − S F x`, with `S` the scattering: `ρ` and, between the sides of a translucent element, `τ`.
    fn apply(&self, scattering: &Scattering, tints: &[Lanes], x: &[Lanes], out: &mut [Lanes]) {
        self.exchange.product(x, tints, out);
        scattering.act(out);
        for (o, x) in out.iter_mut().zip(x) {
            *o = std::array::from_fn(|l| x[l] - o[l]);
        }
    }

    fn stabilised(
        &self,
        scattering: &Scattering,
        source: &[Lanes],
        tints: &[Lanes],
        accuracy: f64,
    ) -> (Vec<Lanes>, usize, f64) {
        let n = source.len();
        let mut x = source.to_vec(); // direct light reflected once: a better start than nothing
        let mut r = vec![[0.0; LANES]; n];
        self.apply(scattering, tints, &x, &mut r);
        for (r, s) in r.iter_mut().zip(source) {
            *r = std::array::from_fn(|l| s[l] - r[l]);
        }
        let shadow = r.clone();
        let (mut p, mut v, mut t) = (r.clone(), vec![[0.0; LANES]; n], vec![[0.0; LANES]; n]);
        let whole = dot(source, source);
        let mut rr = dot(&r, &r);
        let mut along = rr;
        let mut products = 1;
        let relative = |rr: &Lanes| (0..LANES).map(|l| ratio(rr[l], whole[l]).sqrt()).fold(0.0, f64::max);
        for _ in 0..MAX_STEPS {
            if relative(&rr) <= accuracy {
                break;
            }
            self.apply(scattering, tints, &p, &mut v);
            let shadow_v = dot(&shadow, &v);
            let alpha: Lanes = std::array::from_fn(|l| ratio(along[l], shadow_v[l]));
            for i in 0..n {
                for l in 0..LANES {
                    x[i][l] += alpha[l] * p[i][l];
                    r[i][l] -= alpha[l] * v[i][l];
                }
            }
            products += 1;
            if relative(&dot(&r, &r)) <= accuracy {
                rr = dot(&r, &r);
                break;
            }
            self.apply(scattering, tints, &r, &mut t);
            products += 1;
            let (tr, tt) = (dot(&t, &r), dot(&t, &t));
            let omega: Lanes = std::array::from_fn(|l| ratio(tr[l], tt[l]));
            for i in 0..n {
                for l in 0..LANES {
                    x[i][l] += omega[l] * r[i][l];
                    r[i][l] -= omega[l] * t[i][l];
                }
            }
            let next = dot(&shadow, &r);
            let beta: Lanes = std::array::from_fn(|l| ratio(next[l], along[l]) * ratio(alpha[l], omega[l]));
            for i in 0..n {
                for l in 0..LANES {
                    p[i][l] = r[i][l] + beta[l] * (p[i][l] - omega[l] * v[i][l]);
                }
            }
            along = next;
            rr = dot(&r, &r);
        }
        (x, products, relative(&rr))
    }

    /// Sums what is absorbed and what escapes, each on its own.
    fn account(
        &self,
        radiosity: &[Lanes],
        direct: &[Lanes],
        scattering: &Scattering,
        tints: &[Lanes],
        result: &mut BlockResult,
    ) {
        let mut arriving = vec![[0.0; LANES]; radiosity.len()];
        self.exchange.product(radiosity, tints, &mut arriving);
        let mut kept: Vec<Lanes> = scattering.rho.iter().map(|rho| rho.map(|r| 1.0 - r)).collect();
        for (i, j, tau) in &scattering.pairs {
            for side in [i, j] {
                kept[*side] = std::array::from_fn(|l| kept[*side][l] - tau[l]);
            }
        }
        for (i, arriving) in arriving.iter().enumerate() {
            for l in 0..LANES {
                result.absorbed[l] += self.exchange.area[i] * kept[i][l] * (direct[i][l] + arriving[l]);
            }
        }
        for exit in &self.other.exits {
            let i = exit.element as usize;
            let flux = self.exchange.area[i] * f64::from(exit.share);
            let tint = &tints[exit.tint as usize];
            for l in 0..LANES {
                let leaving = flux * radiosity[i][l];
                match exit.way {
                    Way::Escaped => result.escaped[l] += leaving * tint[l],
                    Way::Lost => result.lost[l] += leaving * tint[l],
                    Way::Tinted => result.lost[l] += leaving * (1.0 - tint[l]),
                }
            }
        }
    }
}

/// What elements do with light that arrives.
struct Scattering {
    /// Reflectance of each.
    rho: Vec<Lanes>,
    /// The two sides of a translucent element, and its transmittance.
    pairs: Vec<(usize, usize, Lanes)>,
}

impl Scattering {
    /// From what arrives to what leaves.
    fn act(&self, light: &mut [Lanes]) {
        let passed: Vec<[Lanes; 2]> = self
            .pairs
            .iter()
            .map(|(i, j, tau)| [*j, *i].map(|from| std::array::from_fn(|l| tau[l] * light[from][l])))
            .collect();
        for (light, rho) in light.iter_mut().zip(&self.rho) {
            *light = std::array::from_fn(|l| rho[l] * light[l]);
        }
        for ((i, j, _), sides) in self.pairs.iter().zip(passed) {
            for (to, light_through) in [*i, *j].into_iter().zip(sides) {
                light[to] = std::array::from_fn(|l| light[to][l] + light_through[l]);
            }
        }
    }
}

/// A quotient that is zero where a band has nothing left to do.
fn ratio(a: f64, b: f64) -> f64 {
    if b == 0.0 { 0.0 } else { a / b }
}

fn dot(a: &[Lanes], b: &[Lanes]) -> Lanes {
    let mut sum = [0.0; LANES];
    for (x, y) in a.iter().zip(b) {
        for l in 0..LANES {
            sum[l] += x[l] * y[l];
        }
    }
    sum
}
