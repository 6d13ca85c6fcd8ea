//! nsrm-codegen
