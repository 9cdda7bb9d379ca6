//! Who keeps what happens in a run.

use super::WriteError;
use super::event::{Entry, Event};

/// Keeps the events of a run.
///
/// Laws: recording never changes the run and never fails it; what cannot be kept is told by [`finish`](Self::finish). Times
/// never fall, and the first event is [`Event::Begin`].
pub trait Recorder {
    /// False if events are thrown away, so that none need be made.
    fn is_on(&self) -> bool {
        true
    }

    /// Takes in an event at a simulated time, s.
    fn record(&mut self, time: f64, event: &Event);

    /// Writes what is still held. Events after it may be lost.
    ///
    /// # Errors
    /// The first thing that could not be written, also before.
    fn finish(&mut self) -> Result<(), WriteError> {
        Ok(())
    }
}

impl<R: Recorder + ?Sized> Recorder for &mut R {
    fn is_on(&self) -> bool {
        (**self).is_on()
    }
    fn record(&mut self, time: f64, event: &Event) {
        (**self).record(time, event);
    }
    fn finish(&mut self) -> Result<(), WriteError> {
        (**self).finish()
    }
}

/// Keeps nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Recorder for Silent {
    fn is_on(&self) -> bool {
        false
    }
    fn record(&mut self, _: f64, _: &Event) {}
}

/// Keeps nothing where there is no recorder.
impl<R: Recorder> Recorder for Option<R> {
    fn is_on(&self) -> bool {
        self.as_ref().is_some_and(R::is_on)
    }
    fn record(&mut self, time: f64, event: &Event) {
        if let Some(recorder) = self {
            recorder.record(time, event);
        }
    }
    fn finish(&mut self) -> Result<(), WriteError> {
        self.as_mut().map_or(Ok(()), R::finish)
    }
}

/// Keeps all events in memory, for tests.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory {
    /// What was recorded, in order.
    pub entries: Vec<Entry>,
}

impl Recorder for Memory {
    fn record(&mut self, time: f64, event: &Event) {
        self.entries.push(Entry(time, event.clone()));
    }
}

/// Hands each event to both.
#[derive(Clone, Debug, Default)]
pub struct Both<A, B>(pub A, pub B);

impl<A: Recorder, B: Recorder> Recorder for Both<A, B> {
    fn is_on(&self) -> bool {
        self.0.is_on() || self.1.is_on()
    }
    fn record(&mut self, time: f64, event: &Event) {
        self.0.record(time, event);
        self.1.record(time, event);
    }
    fn finish(&mut self) -> Result<(), WriteError> {
        let first = self.0.finish();
        self.1.finish().and(first)
    }
}
