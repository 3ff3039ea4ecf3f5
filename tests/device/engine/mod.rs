//! Demands of an engine on the facade: its meshes as it stores them, its cameras, its textures, its threads.

mod adopter;
mod cameras;

mod contract;
mod devices;
mod exposed;
mod kinds;
mod meshes;
mod misbehaving;
mod parts;
mod renderer;
mod steps;
mod threads;
mod views;
