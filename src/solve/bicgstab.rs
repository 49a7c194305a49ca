//! Stabilised bi-conjugate gradients (van der Vorst 1992) on `(I − SF) B = SD`, `S` the reflectances and transmittances, eight bands abreast.
//!
//! Sampled rows are not reciprocal, so the symmetric form is not open. One isolated eigenvalue goes to one with the
//! reflectance; a Krylov method takes it in a step or two, where sweeps need 1/(1 − ρ) of them.

use rayon::prelude::*;

use super::exchange::{Exchange, Exit, Way};
use super::scattering::Scattering;
use crate::mesh::Elements;
use crate::transport::{Optics, Rows, World};

/// Bands in a block.
pub const LANES: usize = 8;
/// Values of the right-hand sides that are solved abreast.
pub type Lanes = [f64; LANES];
const MAX_STEPS: usize = 200;
/// Elements that are worth a task; sums are taken piece by piece, so that they do not depend on the number of threads.
pub(super) const PIECE: usize = 1 << 12;

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
    /// What leaves by the rays of another replica: an element's own rays also made its radiosity, and the product of the
    /// two would count too little.
    pub(super) exits: &'a [Exit],
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
    /// Bytes that an element takes: eight vectors, the result, material and side.
    pub(super) fn bytes_per_element() -> usize {
        8 * size_of::<Lanes>() + size_of::<[f32; LANES]>() + size_of::<(u32, bool)>()
    }

    /// Solves to a relative residual of `accuracy` in every band.
    #[must_use]
    pub fn solve(&self, accuracy: f64) -> BlockResult {
        let tints: Vec<Lanes> = self.rows.tints.iter().map(|t| self.lanes(t)).collect();
        let direct = self.direct(&tints);
        let scattering = Scattering::new(self.world, self.optics, self.mesh, |bands| self.lanes(bands));
        let source: Vec<Lanes> = if self.world.glowing() {
            self.emitted()
        } else {
            let mut source = direct.clone();
            scattering.act(&mut source);
            source
        };
        let system = System { exchange: self.exchange, scattering: &scattering, tints: &tints };
        let (radiosity, products, residual) = system.solve(source, accuracy);
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
        for seen in &replica.mirrored {
            let (d, m) = (&mut direct[seen.element as usize], &exitance[seen.group as usize]);
            let share = per_ray * f64::from(seen.share * seen.weight);
            for l in 0..LANES {
                d[l] += share * tints[seen.tint as usize][l] * m[l];
            }
        }
        direct
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
        let kept = scattering.absorbed();
        for (i, arriving) in arriving.iter().enumerate() {
            for l in 0..LANES {
                result.absorbed[l] += self.exchange.area[i] * kept[i][l] * (direct[i][l] + arriving[l]);
            }
        }
        for exit in self.exits {
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

/// `(I − SF) B = s` for eight right-hand sides abreast.
#[derive(Clone, Copy, Debug)]
pub(super) struct System<'a> {
    pub(super) exchange: &'a Exchange,
    pub(super) scattering: &'a Scattering,
    pub(super) tints: &'a [Lanes],
}

impl System<'_> {
    /// `out = x − S F x`.
    fn apply(&self, x: &[Lanes], out: &mut [Lanes]) {
        self.exchange.product(x, self.tints, out);
        self.scattering.act(out);
        pieces(out, x).for_each(|(out, x)| {
            for (o, x) in out.iter_mut().zip(x) {
                *o = std::array::from_fn(|l| x[l] - o[l]);
            }
        });
    }

    /// Radiosities for a source of reflected direct light, to a relative residual of `accuracy` in every lane; products
    /// needed, and the residual.
    pub(super) fn solve(&self, source: Vec<Lanes>, accuracy: f64) -> (Vec<Lanes>, usize, f64) {
        let n = source.len();
        let whole = dot(&source, &source);
        let mut x = source; // direct light reflected once: a better start than nothing
        let mut r = vec![[0.0; LANES]; n];
        self.apply(&x, &mut r);
        add_times(&mut r, &x, &[-1.0; LANES]);
        scale(&mut r, &[-1.0; LANES]);
        let shadow = r.clone();
        let (mut p, mut v, mut t) = (r.clone(), vec![[0.0; LANES]; n], vec![[0.0; LANES]; n]);
        let mut rr = dot(&r, &r);
        let mut along = rr;
        let mut products = 1;
        let relative = |rr: &Lanes| (0..LANES).map(|l| ratio(rr[l], whole[l]).sqrt()).fold(0.0, f64::max);
        for _ in 0..MAX_STEPS {
            if relative(&rr) <= accuracy {
                break;
            }
            self.apply(&p, &mut v);
            let shadow_v = dot(&shadow, &v);
            let alpha: Lanes = std::array::from_fn(|l| ratio(along[l], shadow_v[l]));
            add_times(&mut x, &p, &alpha);
            add_times(&mut r, &v, &alpha.map(|a| -a));
            products += 1;
            rr = dot(&r, &r);
            if relative(&rr) <= accuracy {
                break;
            }
            self.apply(&r, &mut t);
            products += 1;
            let (tr, tt) = (dot(&t, &r), dot(&t, &t));
            let omega: Lanes = std::array::from_fn(|l| ratio(tr[l], tt[l]));
            add_times(&mut x, &r, &omega);
            add_times(&mut r, &t, &omega.map(|o| -o));
            let next = dot(&shadow, &r);
            let beta: Lanes = std::array::from_fn(|l| ratio(next[l], along[l]) * ratio(alpha[l], omega[l]));
            // p = r + β (p − ω v)
            add_times(&mut p, &v, &omega.map(|o| -o));
            scale(&mut p, &beta);
            add_times(&mut p, &r, &[1.0; LANES]);
            along = next;
            rr = dot(&r, &r);
        }
        (x, products, relative(&rr))
    }
}

/// A quotient that is zero where a band has nothing left to do.
fn ratio(a: f64, b: f64) -> f64 {
    if b == 0.0 { 0.0 } else { a / b }
}

/// Two vectors, piece by piece.
fn pieces<'a>(
    a: &'a mut [Lanes],
    b: &'a [Lanes],
) -> impl IndexedParallelIterator<Item = (&'a mut [Lanes], &'a [Lanes])> {
    a.par_chunks_mut(PIECE).zip(b.par_chunks(PIECE))
}

/// `a += times · b`.
fn add_times(a: &mut [Lanes], b: &[Lanes], times: &Lanes) {
    pieces(a, b).for_each(|(a, b)| {
        for (a, b) in a.iter_mut().zip(b) {
            (0..LANES).for_each(|l| a[l] += times[l] * b[l]);
        }
    });
}

fn scale(a: &mut [Lanes], times: &Lanes) {
    a.par_chunks_mut(PIECE).for_each(|a| a.iter_mut().for_each(|a| (0..LANES).for_each(|l| a[l] *= times[l])));
}

fn dot(a: &[Lanes], b: &[Lanes]) -> Lanes {
    let of_piece = |(a, b): (&[Lanes], &[Lanes])| {
        let mut sum = [0.0; LANES];
        for (x, y) in a.iter().zip(b) {
            (0..LANES).for_each(|l| sum[l] += x[l] * y[l]);
        }
        sum
    };
    let sums: Vec<Lanes> = a.par_chunks(PIECE).zip(b.par_chunks(PIECE)).map(of_piece).collect();
    sums.iter().fold([0.0; LANES], |all, s| std::array::from_fn(|l| all[l] + s[l]))
}
