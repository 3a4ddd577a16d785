//! What the guard decides, by its reasons; one program, since each links the whole guard.

mod blind;
mod dust;
mod laws;
mod limits;
mod measured;
mod near;
mod thresholds;
mod time;
mod zones;
