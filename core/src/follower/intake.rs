//! The setpoints that come: each is checked, at once or in parts, and queued.

use crate::Scalar;
use crate::acceptance::{self, Progress, Refusal, Setpoint, SheetView};
use crate::follower::{Follower, Reason, State};

impl<T: Scalar, const GROUPS: usize, const KNOTS: usize> Follower<T, GROUPS, KNOTS> {
    /// Queues a setpoint. An invalid setpoint holds the motion.
    ///
    /// Cost: for each group a sine, a cosine and nine places of a curve, and for each star the residual twice. Half angles
    /// cost more: a few hundred multiplications for each group and, if they are homogeneous, some thousands for each star.
    ///
    /// # Errors
    /// The reason why the setpoint is not followed; nothing but the hold has changed then. It is the first defect, in this
    /// order: of the setpoint's number, of its other numbers and their order in time, of the limits, of closure at the
    /// setpoint, of the segment.
    pub fn accept(
        &mut self,
        sheet: &SheetView<'_, T>,
        setpoint: Setpoint<T, GROUPS>,
    ) -> Result<(), Refusal> {
        self.offer(sheet, setpoint)?;
        while !self.check_on(sheet, u32::MAX)? {}
        Ok(())
    }

    /// Begins to check a setpoint, which [`check_on`](Self::check_on) goes on with: for a controller that cannot wait for
    /// the bounds of all essential vertices. A setpoint that was offered before and is not queued yet is dropped.
    ///
    /// Cost: that of [`accept`](Self::accept) without the bounds of homogeneous half angles.
    ///
    /// # Errors
    /// As [`accept`](Self::accept).
    pub fn offer(
        &mut self,
        sheet: &SheetView<'_, T>,
        setpoint: Setpoint<T, GROUPS>,
    ) -> Result<(), Refusal> {
        self.pending = None;
        if !matches!(self.state, State::Ready | State::Running | State::Holding) {
            return Err(Refusal::State);
        }
        if self.room() == 0 {
            return Err(Refusal::Full);
        }
        let in_order = setpoint.number == self.next && !self.ended;
        let checked = if in_order {
            acceptance::check_places(sheet, self.queue.setpoints().back(), &setpoint)
        } else {
            Err(Refusal::Sequence(self.next))
        };
        checked.map_err(|refusal| self.refuse(refusal))?;
        self.pending = Some((setpoint, Progress::default()));
        Ok(())
    }

    /// Goes on to check the setpoint that was [offered](Self::offer), with bounds on at most `parts` parts of its segment:
    /// one to three for each essential vertex of an ordinary segment. Returns `true` once it is queued.
    ///
    /// Cost of a part: about 100 multiplications by the squared number of the vertex's spokes.
    ///
    /// # Errors
    /// As [`accept`](Self::accept); the setpoint is dropped then. [`Refusal::State`] also if no setpoint is being checked,
    /// which is so once the path was dropped or the motion has failed.
    pub fn check_on(&mut self, sheet: &SheetView<'_, T>, parts: u32) -> Result<bool, Refusal> {
        let Some((setpoint, progress)) = &mut self.pending else {
            return Err(Refusal::State);
        };
        let before = self.queue.setpoints().back();
        match acceptance::check_bounds(sheet, before, setpoint, progress, parts) {
            Ok(true) => {}
            Ok(false) => return Ok(false),
            Err(refusal) => {
                self.pending = None;
                return Err(self.refuse(refusal));
            }
        }
        // Not taken, which would move it by way of the stack.
        let setpoint = setpoint.clone();
        self.pending = None;
        self.next = self.next.wrapping_add(1);
        self.ended = setpoint.last;
        self.queue.push(setpoint)?;
        Ok(true)
    }

    /// Holds the motion because of a setpoint.
    fn refuse(&mut self, refusal: Refusal) -> Refusal {
        self.hold(Reason::Refused(refusal));
        refusal
    }
}
