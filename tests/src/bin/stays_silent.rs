//! A service that runs and does nothing: no port is opened, no heartbeat sent.

fn main() {
    loop {
        std::thread::park();
    }
}
