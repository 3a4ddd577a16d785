//! Maps for tests and benches: drawn as text, or made from a seed.

#![allow(dead_code, reason = "every test and bench uses its own part")]

pub(crate) mod cycle;

use zeronav_casts::Cast;
use zeronav_msgs::map::{COST_INSCRIBED, COST_LETHAL, FLAG_SENSED, FLAG_STATIC};
use zeronav_msgs::{Cell, CellRect, GridGeometry, MapCell, MapView, Pose};

/// A map that owns its cells.
#[derive(Debug, Clone)]
pub(crate) struct Map {
    pub(crate) geometry: GridGeometry,
    pub(crate) cells: Vec<MapCell>,
}

impl Map {
    /// All free, 5 cm cells, origin off zero so that cells and metres cannot be mixed up.
    pub(crate) fn free(width: u32, height: u32) -> Self {
        let geometry = GridGeometry {
            origin_x_m: -1.5,
            origin_y_m: 2.25,
            resolution_m: 0.05,
            width,
            height,
        };
        let cells = vec![of_cost(0); geometry.len()];
        Self { geometry, cells }
    }

    /// Reads a drawing, the last line is row 0: `#` lethal, `+` inscribed, `?` unknown, `1` to `9`
    /// a cost of 25 times that, anything else free. Gives also where the letters stand.
    pub(crate) fn drawn(text: &str) -> (Self, impl Fn(char) -> Cell) {
        let lines: Vec<&str> = text
            .lines()
            .map(str::trim)
            .filter(|l| !l.is_empty())
            .collect();
        let width = lines[0].chars().count();
        let mut map = Self::free(
            u32::try_from(width).unwrap(),
            u32::try_from(lines.len()).unwrap(),
        );
        let mut letters = Vec::new();
        for (line, y) in lines.iter().rev().zip(0..) {
            assert_eq!(line.chars().count(), width, "ragged drawing");
            for (c, x) in line.chars().zip(0..) {
                let cell = Cell::new(x, y);
                match c {
                    '#' => map.put(cell, of_cost(COST_LETHAL)),
                    '+' => map.put(cell, of_cost(COST_INSCRIBED)),
                    '?' => map.put(cell, MapCell::unknown(1000)),
                    '1'..='9' => {
                        let digit = u8::try_from(c.to_digit(10).unwrap()).unwrap();
                        map.put(cell, of_cost(25 * digit));
                    }
                    letter if letter.is_alphabetic() => letters.push((letter, cell)),
                    _ => {}
                }
            }
        }
        (map, move |letter| {
            letters
                .iter()
                .find(|(l, _)| *l == letter)
                .expect("letter in the drawing")
                .1
        })
    }

    pub(crate) fn put(&mut self, cell: Cell, value: MapCell) {
        if let Some(index) = self.geometry.index_of(cell) {
            self.cells[index] = value;
        }
    }

    pub(crate) fn view(&self) -> MapView<'_> {
        MapView {
            geometry: &self.geometry,
            cells: &self.cells,
        }
    }

    /// Pose at the centre of a cell.
    pub(crate) fn pose(&self, cell: Cell) -> Pose {
        let centre = self.geometry.centre_of(cell);
        Pose::new(centre.x, centre.y, 0.25)
    }

    /// Fills a rectangle of cells with obstacles.
    pub(crate) fn block(&mut self, min: Cell, max: Cell) {
        for y in min.y..max.y {
            for x in min.x..max.x {
                self.put(Cell::new(x, y), of_cost(COST_LETHAL));
            }
        }
    }

    /// Gives free cells the costs of the obstacles around them.
    pub(crate) fn inflate(&mut self, inscribed_m: f64, radius_m: f64, factor: f64) {
        let resolution_m = self.geometry.resolution_m;
        let reach = (radius_m / resolution_m).ceil().to_i32() + 1;
        let (width, height) = self.geometry.size();
        let lethal: Vec<Cell> = (0..height)
            .flat_map(|y| (0..width).map(move |x| Cell::new(x, y)))
            .filter(|cell| self.view().get(*cell).unwrap().cost == COST_LETHAL)
            .collect();
        for from in lethal {
            for y in -reach..=reach {
                for x in -reach..=reach {
                    let gap = |d: i32| (f64::from(d.abs()) - 0.5).max(0.0);
                    let clearance_m = gap(x).hypot(gap(y)) * resolution_m;
                    let cost = if clearance_m > radius_m {
                        continue;
                    } else if clearance_m <= inscribed_m {
                        COST_INSCRIBED
                    } else {
                        (252.0 * (-factor * (clearance_m - inscribed_m)).exp()).to_u8()
                    };
                    let cell = Cell::new(from.x + x, from.y + y);
                    if let Some(index) = self.geometry.index_of(cell) {
                        let old = self.cells[index];
                        if old.cost < cost {
                            self.cells[index] = of_cost(cost);
                        }
                    }
                }
            }
        }
    }

    /// Rooms of 5 m along corridors, with doors and furniture; 600 x 400 is 30 m x 20 m.
    pub(crate) fn office(width: u32, height: u32, seed: u64) -> Self {
        let mut map = Self::free(width, height);
        let mut rng = Rng(seed);
        let (w, h) = map.geometry.size();
        map.block(Cell::new(0, 0), Cell::new(w, 2));
        map.block(Cell::new(0, h - 2), Cell::new(w, h));
        map.block(Cell::new(0, 0), Cell::new(2, h));
        map.block(Cell::new(w - 2, 0), Cell::new(w, h));
        let room = 100;
        for row in 1..h / room {
            let y = row * room;
            map.block(Cell::new(0, y), Cell::new(w, y + 3));
            for column in 0..w / room {
                let x = column * room + 10 + rng.below(60);
                open(&mut map, Cell::new(x, y), Cell::new(x + 24, y + 3));
            }
        }
        for column in 1..w / room {
            let x = column * room;
            map.block(Cell::new(x, 0), Cell::new(x + 3, h));
            for row in 0..h / room {
                let y = row * room + 10 + rng.below(60);
                open(&mut map, Cell::new(x, y), Cell::new(x + 3, y + 24));
            }
        }
        for _ in 0..w * h / 4000 {
            let at = Cell::new(rng.below(w), rng.below(h));
            let size = Cell::new(2 + rng.below(10), 2 + rng.below(10));
            map.block(at, Cell::new(at.x + size.x, at.y + size.y));
        }
        map.inflate(0.2, 0.6, 4.0);
        map
    }

    /// Three blocks of racks with two aisles of 2 m between them, 30 m x 20 m, and the ends of a
    /// way through the south aisle.
    pub(crate) fn warehouse() -> (Self, Cell, Cell) {
        let mut map = Self::free(600, 400);
        let (w, h) = map.geometry.size();
        for (min, max) in [
            ((0, 0), (w, 4)),
            ((0, h - 4), (w, h)),
            ((0, 0), (4, h)),
            ((w - 4, 0), (w, h)),
            ((140, 6), (458, 108)),
            ((140, 149), (458, 251)),
            ((140, 292), (458, 394)),
        ] {
            map.block(Cell::new(min.0, min.1), Cell::new(max.0, max.1));
        }
        for (x, y) in [
            (92, 68),
            (92, 200),
            (92, 332),
            (508, 68),
            (508, 200),
            (508, 332),
        ] {
            map.block(Cell::new(x - 4, y - 4), Cell::new(x + 4, y + 4));
        }
        map.inflate(0.2, 0.6, 4.0);
        (map, Cell::new(165, 128), Cell::new(540, 170))
    }

    /// A load fills the south aisle of the warehouse 3 m before the robot; what changed.
    pub(crate) fn drop_load(&mut self) -> CellRect {
        self.block(Cell::new(218, 110), Cell::new(234, 147));
        self.inflate(0.2, 0.6, 4.0);
        CellRect {
            min: Cell::new(204, 96),
            max: Cell::new(248, 161),
        }
    }

    /// The free cell nearest to `cell` in reading order of growing squares.
    pub(crate) fn free_near(&self, cell: Cell) -> Cell {
        (0..200)
            .flat_map(|r| (-r..=r).flat_map(move |y| (-r..=r).map(move |x| (x, y))))
            .map(|(x, y)| Cell::new(cell.x + x, cell.y + y))
            .find(|c| {
                self.view()
                    .get(*c)
                    .is_some_and(|cell| !cell.blocks_centre())
            })
            .expect("a free cell")
    }
}

fn open(map: &mut Map, min: Cell, max: Cell) {
    for y in min.y..max.y {
        for x in min.x..max.x {
            map.put(Cell::new(x, y), of_cost(0));
        }
    }
}

/// A known cell of this cost.
pub(crate) fn of_cost(cost: u8) -> MapCell {
    MapCell {
        cost,
        flags: if cost == COST_LETHAL {
            FLAG_STATIC | FLAG_SENSED
        } else {
            0
        },
        clearance_mm: if cost == COST_LETHAL { 0 } else { 500 },
    }
}

/// `SplitMix64`: seeds are printed by the tests, so that a failure can be repeated.
#[derive(Debug, Clone)]
pub(crate) struct Rng(pub(crate) u64);

impl Rng {
    pub(crate) fn draw(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// 0 to `n - 1`.
    pub(crate) fn below(&mut self, n: i32) -> i32 {
        i32::try_from(self.draw() % u64::try_from(n.max(1)).unwrap()).unwrap()
    }
}
