//! The second half of a log's work, on a thread of its own: compressing costs
//! several times as much as encoding, and this way neither waits for the other.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

use super::chunk::{Chunk, Sealer};
use super::file::LogFile;

/// Chunks in all: one being filled, one being compressed, one between.
const CHUNKS: usize = 3;

/// Sends chunks to the file.
pub(super) struct ChunkQueue {
    to_file: SyncSender<Chunk>,
    from_file: Receiver<Chunk>,
    thread: JoinHandle<io::Result<LogFile>>,
}

impl ChunkQueue {
    /// Starts the thread that writes to `file`. Sets `failed` once the file
    /// takes no more. Also returns the first chunk to fill.
    pub fn start(mut file: LogFile, channels: usize, failed: Arc<AtomicBool>) -> io::Result<(Self, Chunk)> {
        let mut sealer = Sealer::new()?;
        let (to_file, full) = sync_channel::<Chunk>(CHUNKS);
        let (empty, from_file) = sync_channel(CHUNKS);
        for _ in 1..CHUNKS {
            let _ = empty.send(Chunk::new(channels));
        }
        let write = move || {
            for mut chunk in full {
                let written = sealer.seal(&mut chunk).and_then(|sealed| file.chunk(sealed));
                if let Err(error) = written {
                    failed.store(true, Ordering::Relaxed);
                    file.cut_to_whole_records();
                    return Err(error);
                }
                // Nobody takes it back once the log is being closed.
                let _ = empty.send(chunk);
            }
            Ok(file)
        };
        let thread = Builder::new().name("log-file".to_owned()).spawn(write)?;
        Ok((Self { to_file, from_file, thread }, Chunk::new(channels)))
    }

    /// Sends what `chunk` holds and leaves it empty; waits while all chunks
    /// are on their way. Once the file has failed, the content is dropped.
    pub fn send(&self, chunk: &mut Chunk) {
        match self.from_file.recv() {
            Ok(empty) => {
                let _ = self.to_file.send(std::mem::replace(chunk, empty));
            }
            Err(_) => chunk.clear(),
        }
    }

    /// Waits until all chunks are written and gives the file back.
    pub fn finish(self) -> io::Result<LogFile> {
        drop(self.to_file);
        self.thread.join().unwrap_or_else(|_| Err(io::Error::other("the thread that compresses it has panicked")))
    }
}
