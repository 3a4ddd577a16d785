//! How many random maps of each family can be crossed, and what they look like.
//!
//! ```sh
//! cargo run --release -p zeronav-world --example random_maps -- 30 20 200
//! ```
//!
//! Columns, rows, and maps per row of the table.

#![allow(clippy::print_stdout, reason = "a table for people")]

use std::error::Error;
use zeronav_msgs::Cell;
use zeronav_world::Occupancy;
use zeronav_world::generate::{Generated, generate};
use zeronav_world::spec::{Family, GeneratedSpec};

fn main() -> Result<(), Box<dyn Error>> {
    let mut numbers = std::env::args().skip(1);
    let mut next = |other: u32| numbers.next().map_or(Ok(other), |word| word.parse());
    let (columns, rows, n_maps) = (next(30)?, next(20)?, next(200)?);
    println!("{columns} x {rows} cells, {n_maps} maps each\n");
    println!("family     ratio   tried  acceptance");
    let mut shown = Vec::new();
    for (name, family) in [
        ("iid", Family::Iid),
        ("blocky", Family::Blocky { side_cells_max: 4 }),
        ("concave", Family::Concave { side_cells_max: 8 }),
        ("corridor", Family::Corridor { width_cells: 2 }),
    ] {
        let ratios: &[f64] = match family {
            Family::Corridor { .. } => &[0.0],
            _ => &[0.1, 0.15, 0.2, 0.25, 0.3, 0.35],
        };
        for ratio in ratios {
            let mut tried = 0;
            for seed in 0..u64::from(n_maps) {
                let generated = generate(&GeneratedSpec {
                    family,
                    size_cells: [columns, rows],
                    ratio: *ratio,
                    start_cell: None,
                    goal_cell: None,
                    seed,
                    resolution_m: 1.0,
                })?;
                tried += generated.tried;
                if seed == 0 && ((ratio - 0.2).abs() < 0.01 || *ratio <= 0.0) {
                    shown.push((name, generated));
                }
            }
            let rate = f64::from(n_maps) / f64::from(tried);
            println!("{name:10} {ratio:5.2} {tried:7} {rate:11.3}");
        }
    }
    for (name, generated) in &shown {
        println!("\n{name}\n{}", drawn(generated));
    }
    Ok(())
}

/// A row of text for each row of cells, the uppermost first.
fn drawn(generated: &Generated) -> String {
    let (columns, rows) = generated.map.geometry.size();
    let mark = |cell: Cell| match generated.map.get(cell) {
        _ if cell == generated.start => 'S',
        _ if cell == generated.goal => 'G',
        Some(Occupancy::Occupied) => '#',
        _ => '.',
    };
    let row = |y: i32| -> String { (0..columns).map(|x| mark(Cell::new(x, y))).collect() };
    (0..rows).rev().map(row).collect::<Vec<_>>().join("\n")
}
