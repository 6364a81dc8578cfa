//! Tests of the controller's program on the host, in virtual time, with one module for each subject.

mod elsewhere;
mod faults;
mod fuzz;
mod jog;
mod links;
mod lives;
mod loading;
mod machine;
mod path;
mod player;
mod port;
mod power_on;
mod refusals;
mod resets;
mod servo_buses;
mod stops;
mod week;
mod world;
