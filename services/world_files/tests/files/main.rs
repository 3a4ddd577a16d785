//! Files of maps and worlds: what is read, rejected and written.

#[path = "../../../../tests/data/folder.rs"]
mod data;
mod data_sets;
mod map_files;
mod random_maps;
mod ros_maps;
mod shipped_data;
