//! Identification from recordings: ARX, gain regression, excitation.
