//! The machine base: its modes and the equivalent spring-mass chain.
