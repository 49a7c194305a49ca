//! Well-spread random numbers from counters: the same for any number of threads.

use std::sync::LazyLock;

/// Dimensions of the point set; deeper bounces take further dimensions, then wrap with new scrambling.
const DIMENSIONS: usize = 10;
/// Points that are tabulated.
const TABLE: usize = 1 << 16;

/// Primitive polynomials and initial direction numbers (Joe and Kuo 2008, set new-joe-kuo-6), dimensions 2 to 10.
const JOE_KUO: [(u32, u32, &[u32]); DIMENSIONS - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
];

static SOBOL: LazyLock<Vec<[u32; DIMENSIONS]>> = LazyLock::new(sobol_table);

fn directions(dimension: usize) -> [u32; 32] {
    let mut v = [0u32; 32];
    if dimension == 0 {
        for (k, x) in v.iter_mut().enumerate() {
            *x = 1 << (31 - k);
        }
        return v;
    }
    let (s, a, m) = JOE_KUO[dimension - 1];
    let s = s as usize;
    for k in 0..32 {
        v[k] = if k < s {
            m[k] << (31 - k)
        } else {
            let mut x = v[k - s] ^ (v[k - s] >> s);
            for j in 1..s {
                if (a >> (s - 1 - j)) & 1 == 1 {
                    x ^= v[k - j];
                }
            }
            x
        };
    }
    v
}

fn sobol_table() -> Vec<[u32; DIMENSIONS]> {
    let v: Vec<[u32; 32]> = (0..DIMENSIONS).map(directions).collect();
    let mut table = vec![[0u32; DIMENSIONS]; TABLE];
    for i in 1..TABLE {
        let bit = i.trailing_zeros() as usize;
        let before = i & (i - 1); // without its lowest bit
        for d in 0..DIMENSIONS {
            table[i][d] = table[before][d] ^ v[d][bit];
        }
    }
    table
}

/// Mixes 64 bits (the finaliser of SplitMix64, Steele, Lea and Flood 2014).
#[must_use]
pub fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A seed for a named purpose.
#[must_use]
pub fn seed(parts: &[u64]) -> u64 {
    parts.iter().fold(0x243f_6a88_85a3_08d3, |h, p| mix(h ^ mix(*p)))
}

/// A scrambled Sobol sequence: every prefix of a power of two is stratified in each pair of dimensions.
///
/// Source: Sobol 1967; nested uniform scrambling (Owen 1995) by the hash of Laine and Karras 2011, in the form of
/// Burley 2020.
#[derive(Clone, Copy, Debug)]
pub struct Points {
    seed: u64,
}

impl Points {
    /// A sequence of its own for every seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// Coordinate `dimension` of point `index`, in `[0, 1)`.
    #[must_use]
    #[inline]
    pub fn get(&self, index: u32, dimension: u32) -> f64 {
        let round = u64::from(dimension) / DIMENSIONS as u64 + ((u64::from(index) / TABLE as u64) << 32);
        let mut place = index as usize % TABLE;
        if round > 0 {
            // Dimensions beyond the table take the same points in another order, so that they do not move together.
            place = (owen((place as u32) << 16, mix(self.seed ^ round) as u32) >> 16) as usize;
        }
        let raw = SOBOL[place][dimension as usize % DIMENSIONS];
        let key = mix(self.seed ^ (round << 8) ^ u64::from(dimension) << 48) as u32;
        f64::from(owen(raw, key)) * (1.0 / 4_294_967_296.0)
    }

    /// Two neighbouring coordinates, a point of the unit square.
    #[must_use]
    #[inline]
    pub fn pair(&self, index: u32, dimension: u32) -> (f64, f64) {
        (self.get(index, dimension), self.get(index, dimension + 1))
    }
}

#[inline]
fn owen(x: u32, key: u32) -> u32 {
    let mut x = x.reverse_bits();
    x = x.wrapping_add(key);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_of_dimensions_is_stratified() {
        let points = Points::new(7);
        for (a, b) in [(0, 1), (2, 3), (0, 3), (4, 5)] {
            // A (0, m, 2)-net holds one point in each of 16 x 16 cells for the first pair; other pairs of the
            // sequence have quality t > 0, so only the one-dimensional strata are exact.
            for d in [a, b] {
                let mut seen = [0u32; 256];
                for i in 0..256 {
                    seen[(points.get(i, d) * 256.0) as usize] += 1;
                }
                assert!(seen.iter().all(|n| *n == 1), "dimension {d}");
            }
        }
        let mut cells = [0u32; 256];
        for i in 0..256 {
            let (x, y) = points.pair(i, 0);
            cells[(x * 16.0) as usize * 16 + (y * 16.0) as usize] += 1;
        }
        assert!(cells.iter().all(|n| *n == 1));
    }

    #[test]
    fn seeds_give_independent_means() {
        let mean = |s| (0..64).map(|i| Points::new(s).get(i, 0).powi(2)).sum::<f64>() / 64.0;
        let (a, b) = (mean(1), mean(2));
        assert!(a != b && (a - 1.0 / 3.0).abs() < 0.01 && (b - 1.0 / 3.0).abs() < 0.01, "{a} {b}");
    }
}
