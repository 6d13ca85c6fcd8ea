//! nsrm-python
