//! nsrm-ipc
