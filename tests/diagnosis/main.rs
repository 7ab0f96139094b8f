//! The diagnosis and the comparison, on simulated and on measured recordings.

#[path = "../support/mod.rs"]
mod support;

mod changed_gain;
mod check;
mod coarse_encoder;
mod compare;
mod control_law;
mod delta_a3;
mod diagnose;
mod discrepancy;
mod effects;
mod emps;
mod equals;
mod friction_pairs;
mod gate;
mod grinder_yaxis;
mod lead;
mod longer_travel;
mod look_alike;
mod missing_signals;
mod modes;
mod next_experiment;
mod only_in_training;
mod other_floors;
mod payload_lever;
mod pitch_search;
mod play;
mod servo_diagnosis;
mod stretches;
mod torque_drive;
mod two_sensors;
mod vibration;
mod wide_spot;
