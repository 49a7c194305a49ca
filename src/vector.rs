//! Inner loops compiled twice: for any machine, and for those with AVX2.
//!
//! The arithmetic is the same in both copies (no fused multiply-add, no other order of sums), so that the results are the
//! same to the last bit.

/// Makes a function that runs with the widest vectors of the machine; what it calls has to be `#[inline(always)]`.
macro_rules! wide {
    ($(#[$note:meta])* $vis:vis fn $name:ident($($arg:ident: $type:ty),+ $(,)?) $body:block) => {
        $(#[$note])*
        #[inline]
        $vis fn $name($($arg: $type),+) {
            #[inline(always)]
            fn any($($arg: $type),+) $body
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn with_avx2($($arg: $type),+) {
                    any($($arg),+);
                }
                if std::arch::is_x86_feature_detected!("avx2") {
                    #[expect(unsafe_code, reason = "the run-time check for AVX2 is the condition of the call")]
                    // SAFETY: the feature was found just above.
                    return unsafe { with_avx2($($arg),+) };
                }
            }
            any($($arg),+);
        }
    };
}
pub(crate) use wide;
