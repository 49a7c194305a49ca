//! Eight numbers at a time: by AVX2 where the machine has it, one after the other elsewhere.
//!
//! Every operation rounds as IEEE 754 says and none is fused with another, so that both give the same to the last bit.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

use super::bvh::WIDTH;

/// A number of single precision in each lane, or a whole number for [`Lanes::lower_index`].
pub(super) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// True or false in each lane.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask>;

    fn all(x: f32) -> Self;
    fn load(from: &[f32; WIDTH]) -> Self;
    fn store(self) -> [f32; WIDTH];
    /// The lesser; `other` where one of both is not a number.
    fn least(self, other: Self) -> Self;
    /// The greater; `other` where one of both is not a number.
    fn most(self, other: Self) -> Self;
    /// Less?
    fn below(self, other: Self) -> Self::Mask;
    /// Less or equal?
    fn up_to(self, other: Self) -> Self::Mask;
    /// Is the bit pattern, taken for a whole number, less?
    fn lower_index(self, other: Self) -> Self::Mask;
    /// Without its sign.
    fn size(self) -> Self;
    /// With the sign of `other`.
    fn signed_as(self, other: Self) -> Self;
    fn pick(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Lane `l` in bit `l`.
    fn bits(mask: Self::Mask) -> u32;
}

/// For every machine.
#[derive(Clone, Copy)]
pub(super) struct Plain([f32; WIDTH]);

/// What is true of each lane of [`Plain`].
#[derive(Clone, Copy)]
pub(super) struct Truths([bool; WIDTH]);

impl Plain {
    #[inline(always)]
    fn with(mut self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        for l in 0..WIDTH {
            self.0[l] = f(self.0[l], other.0[l]);
        }
        self
    }

    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(f32, f32) -> bool) -> Truths {
        let mut out = [false; WIDTH];
        for l in 0..WIDTH {
            out[l] = f(self.0[l], other.0[l]);
        }
        Truths(out)
    }
}

impl Lanes for Plain {
    type Mask = Truths;

    #[inline(always)]
    fn all(x: f32) -> Self {
        Self([x; WIDTH])
    }

    #[inline(always)]
    fn load(from: &[f32; WIDTH]) -> Self {
        Self(*from)
    }

    #[inline(always)]
    fn store(self) -> [f32; WIDTH] {
        self.0
    }

    #[inline(always)]
    fn least(self, other: Self) -> Self {
        self.with(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn most(self, other: Self) -> Self {
        self.with(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn below(self, other: Self) -> Truths {
        self.compare(other, |a, b| a < b)
    }

    #[inline(always)]
    fn up_to(self, other: Self) -> Truths {
        self.compare(other, |a, b| a <= b)
    }

    #[inline(always)]
    fn lower_index(self, other: Self) -> Truths {
        self.compare(other, |a, b| a.to_bits().cast_signed() < b.to_bits().cast_signed())
    }

    #[inline(always)]
    fn size(self) -> Self {
        self.with(self, |a, _| a.abs())
    }

    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        self.with(other, f32::copysign)
    }

    #[inline(always)]
    fn pick(mask: Truths, yes: Self, mut no: Self) -> Self {
        for l in 0..WIDTH {
            no.0[l] = if mask.0[l] { yes.0[l] } else { no.0[l] };
        }
        no
    }

    #[inline(always)]
    fn bits(mask: Truths) -> u32 {
        mask.0.iter().rev().fold(0, |bits, m| bits << 1 | u32::from(*m))
    }
}

impl BitAnd for Truths {
    type Output = Self;

    #[inline(always)]
    fn bitand(mut self, other: Self) -> Self {
        for l in 0..WIDTH {
            self.0[l] &= other.0[l];
        }
        self
    }
}

impl BitOr for Truths {
    type Output = Self;

    #[inline(always)]
    fn bitor(mut self, other: Self) -> Self {
        for l in 0..WIDTH {
            self.0[l] |= other.0[l];
        }
        self
    }
}

macro_rules! operators {
    ($($name:ident $method:ident $op:tt $intrinsic:ident),+) => {
        $(
            impl $name for Plain {
                type Output = Self;

                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    self.with(other, |a, b| a $op b)
                }
            }

            #[cfg(target_arch = "x86_64")]
            impl $name for avx2::Wide {
                type Output = Self;

                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    Self(avx2::call!($intrinsic(self.0, other.0)))
                }
            }
        )+
    };
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::__m256;
    use std::ops::{BitAnd, BitOr};

    use super::{Lanes, WIDTH};

    /// For machines with AVX2: who names it has asked for the feature.
    #[derive(Clone, Copy)]
    pub(in super::super) struct Wide(pub(super) __m256);

    macro_rules! call {
        ($intrinsic:ident $(::<$constant:ident>)? ($($arg:expr),*)) => {{
            #[expect(unsafe_code, reason = "the compiler does not find these instructions by itself in loops over lanes")]
            // SAFETY: the kernels name `Wide` after the run-time check for AVX2 alone; pointers are to whole arrays.
            unsafe { std::arch::x86_64::$intrinsic $(::<{ std::arch::x86_64::$constant }>)? ($($arg),*) }
        }};
    }
    pub(super) use call;

    impl Lanes for Wide {
        type Mask = Self;

        #[inline(always)]
        fn all(x: f32) -> Self {
            Self(call!(_mm256_set1_ps(x)))
        }

        #[inline(always)]
        fn load(from: &[f32; WIDTH]) -> Self {
            Self(call!(_mm256_loadu_ps(from.as_ptr())))
        }

        #[inline(always)]
        fn store(self) -> [f32; WIDTH] {
            let mut to = [0.0; WIDTH];
            call!(_mm256_storeu_ps(to.as_mut_ptr(), self.0));
            to
        }

        #[inline(always)]
        fn least(self, other: Self) -> Self {
            Self(call!(_mm256_min_ps(self.0, other.0)))
        }

        #[inline(always)]
        fn most(self, other: Self) -> Self {
            Self(call!(_mm256_max_ps(self.0, other.0)))
        }

        #[inline(always)]
        fn below(self, other: Self) -> Self {
            Self(call!(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)))
        }

        #[inline(always)]
        fn up_to(self, other: Self) -> Self {
            Self(call!(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)))
        }

        #[inline(always)]
        fn lower_index(self, other: Self) -> Self {
            let (a, b) = (call!(_mm256_castps_si256(self.0)), call!(_mm256_castps_si256(other.0)));
            let less = call!(_mm256_cmpgt_epi32(b, a));
            Self(call!(_mm256_castsi256_ps(less)))
        }

        #[inline(always)]
        fn size(self) -> Self {
            Self(call!(_mm256_andnot_ps(Self::all(-0.0).0, self.0)))
        }

        #[inline(always)]
        fn signed_as(self, other: Self) -> Self {
            self.size() | (Self::all(-0.0) & other)
        }

        #[inline(always)]
        fn pick(mask: Self, yes: Self, no: Self) -> Self {
            Self(call!(_mm256_blendv_ps(no.0, yes.0, mask.0)))
        }

        #[inline(always)]
        fn bits(mask: Self) -> u32 {
            call!(_mm256_movemask_ps(mask.0)).cast_unsigned()
        }
    }

    impl BitAnd for Wide {
        type Output = Self;

        #[inline(always)]
        fn bitand(self, other: Self) -> Self {
            Self(call!(_mm256_and_ps(self.0, other.0)))
        }
    }

    impl BitOr for Wide {
        type Output = Self;

        #[inline(always)]
        fn bitor(self, other: Self) -> Self {
            Self(call!(_mm256_or_ps(self.0, other.0)))
        }
    }
}
#[cfg(target_arch = "x86_64")]
pub(super) use avx2::Wide;

operators!(Add add + _mm256_add_ps, Sub sub - _mm256_sub_ps, Mul mul * _mm256_mul_ps, Div div / _mm256_div_ps);
