//! Spoils files: bytes, numbers, lines and pieces of other samples.

/// Numbers and words at which readers trip.
const TOKENS: [&str; 34] = [
    "0",
    "-1",
    "1",
    "2",
    "3",
    "0.5",
    "-0",
    "1e308",
    "-1e308",
    "1e-308",
    "1e12",
    "1e13",
    "-1e12",
    "9999999999",
    "4294967296",
    "18446744073709551616",
    "100000",
    "NaN",
    "inf",
    "-inf",
    "360",
    "180",
    "90",
    "\n",
    "\r\n",
    ",",
    "\t",
    "\"",
    "",
    "\u{feff}",
    "[",
    "]",
    "<",
    "=",
];

/// Random numbers by counting (Steele, Lea and Flood 2014: SplitMix64).
pub(crate) struct Mutator(u64);

impl Mutator {
    /// Stream of a number.
    pub(crate) fn new(stream: u64) -> Self {
        Self(stream.wrapping_mul(0xd134_2543_de82_ef95))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below `n`, which is not zero.
    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// A piece of a file, as two ends; numbers and words as often as anything else.
    fn piece(&mut self, file: &[u8]) -> (usize, usize) {
        let at = self.below(file.len() + 1);
        if self.below(2) == 0 {
            let is_part = |b: &u8| b.is_ascii_alphanumeric() || b"+-._".contains(b);
            let from = file[..at].iter().rposition(|b| !is_part(b)).map_or(0, |p| p + 1);
            let to = file[at..].iter().position(|b| !is_part(b)).map_or(file.len(), |p| at + p);
            return (from, to);
        }
        let length = 1 << self.below(8);
        (at, (at + self.below(length) + 1).min(file.len()))
    }

    /// A sample, spoilt in one to eight places.
    pub(crate) fn spoil(&mut self, samples: &[Vec<u8>]) -> Vec<u8> {
        let mut file = samples[self.below(samples.len())].clone();
        for _ in 0..=self.below(8) {
            let (from, to) = self.piece(&file);
            let with: Vec<u8> = match self.below(7) {
                0 => Vec::new(),
                1 => vec![self.next() as u8],
                2 | 3 => TOKENS[self.below(TOKENS.len())].into(),
                4 => file[from..to].repeat(2),
                5 => {
                    let other = &samples[self.below(samples.len())];
                    let (a, b) = self.piece(other);
                    other[a..b].to_vec()
                }
                _ => format!("{}", self.next() as i64 >> self.below(63)).into_bytes(),
            };
            file.splice(from..to, with);
        }
        if self.below(20) == 0 {
            file.truncate(self.below(file.len() + 1));
        }
        file
    }
}
