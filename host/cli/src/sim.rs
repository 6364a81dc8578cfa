//! Runs `foldpath sim`, which serves a simulated controller over TCP.

use core::time::Duration;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread::sleep;
use std::time::Instant;

use foldpath::stream::Sim;

use crate::args::Served;
use crate::link::with_host;
use crate::{Answer, CliError, key, print};

/// Time between two looks at the connection: a fraction of the controller's tick of 1 ms.
const PAUSE: Duration = Duration::from_micros(250);

/// Serves one client after the other until the process is ended.
pub(crate) fn run(args: &Served, quiet: bool) -> Answer {
    let key = args.key.as_deref().map(|path| key::read(path, quiet));
    let key = key.transpose()?;
    let listener = bind(&args.listen).map_err(|error| {
        let address = &args.listen;
        CliError::Usage(format!(
            "--listen {address}: expected HOST:PORT or PORT, an address of this machine that is free; {error}"
        ))
    })?;
    let address = listener.local_addr().map_err(CliError::Output)?;
    print(&format!("sim: listens at {address}\n"))?;
    let nonce = key::nonce().map_err(CliError::Output)?;
    let mut server = Server {
        sim: Sim::serving(key, nonce),
        start: Instant::now(),
        outgoing: Vec::new(),
    };
    loop {
        match listener.accept() {
            Ok((stream, _)) => {
                // A connection that breaks is the client's affair. The controller holds when it hears nothing.
                let _ = server.serve(stream);
            }
            Err(_) => sleep(PAUSE),
        }
        server.pass(&[]);
        server.outgoing.clear();
    }
}

/// Listens at `HOST:PORT`, or at a port of this machine alone.
fn bind(address: &str) -> io::Result<TcpListener> {
    let listener = TcpListener::bind(with_host(address))?;
    listener.set_nonblocking(true)?;
    Ok(listener)
}

/// A controller in real time.
struct Server {
    sim: Sim,
    start: Instant,
    /// Bytes that the connection has not taken yet.
    outgoing: Vec<u8>,
}

impl Server {
    /// Serves a client until it disconnects.
    fn serve(&mut self, mut stream: TcpStream) -> io::Result<()> {
        stream.set_nodelay(true)?;
        stream.set_nonblocking(true)?;
        let mut buffer = [0; 4096];
        loop {
            match stream.read(&mut buffer) {
                Ok(0) => return Ok(()),
                Ok(count) => self.pass(buffer.get(..count).unwrap_or(&[])),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    sleep(PAUSE);
                    self.pass(&[]);
                }
                Err(error) => return Err(error),
            }
            match stream.write(&self.outgoing) {
                Ok(count) => drop(self.outgoing.drain(..count)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// Hands bytes to the controller and lets it run until now. It says nothing more while the connection takes nothing.
    fn pass(&mut self, incoming: &[u8]) {
        let now = u64::try_from(self.start.elapsed().as_micros()).unwrap_or(u64::MAX);
        self.sim.pass(now, incoming, &mut self.outgoing);
    }
}
