//! See `nsrm_tests::fuzz::TARGETS`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| nsrm_tests::fuzz::feedback(bytes));
