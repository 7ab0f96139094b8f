//! What is recorded, real or simulated alike.
