#![no_main]

#[path = "../../tests/readers_never_panic/readers.rs"]
#[allow(dead_code, reason = "each target takes one reader of the list")]
mod readers;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    readers::ies(bytes);
});
