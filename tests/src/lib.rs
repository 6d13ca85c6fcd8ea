//! nsrm-tests
