//! nsrm
