#!/usr/bin/python3
"""A browser steps through the answers of a robot: those that the server recorded, and those of a file."""
import json
import sys

sys.dont_write_bytecode = True
from support import Keys, PageTest, Robot, main, read_log  # noqa: E402

RECORDED = 8


class PlaybackTest(PageTest):
    server_options = ("--recorded-answers", str(RECORDED))

    @classmethod
    def set_up_server(cls):
        cls.import_map("willow", cls.arguments.map)
        log = cls.simulate("robot", "--seed", "1", "--length", "40", "--noise", "0.03")
        elsewhere = cls.simulate("elsewhere", "--seed", "5", "--length", "15")
        robot = Robot(cls.server, log, "cart-7")
        robot.drive_until("localized")
        for _ in range(8):
            robot.drive()
        robot.carry(read_log(elsewhere)[1])
        cls.robot = robot
        cls.history = cls.server.call("GET", f"/v1/sessions/{robot.id}/history")["answers"]
        cls.first_recorded = cls.history[-RECORDED]["sequence"]

    def open_answer(self, sequence):
        self.open(f"#session={self.robot.id}&answer={sequence}")
        self.wait_for_text("#history-entry", f"Answer {sequence},")

    def save_recording(self):
        self.browser.execute_cdp_cmd("Browser.setDownloadBehavior",
                                     {"behavior": "allow", "downloadPath": str(self.directory)})
        file = self.directory / "cart-7.recording.json"
        file.unlink(missing_ok=True)
        self.open(f"#session={self.robot.id}")
        self.wait_for(lambda: self.is_shown("#save-recording"), "the history")
        self.wait_for_text("#robot-facts", "Answer")
        self.find("#save-recording").click()
        self.wait_for(file.exists, "the recording")
        self.wait_for(lambda: file.read_bytes().endswith(b"}"), "a whole recording")
        return file

    def test_a_link_leads_to_an_answer_of_the_past_with_its_scan(self):
        self.open_answer(self.first_recorded)
        self.wait_for(lambda: len(self.all("#fit-pictures canvas")) == 1, "the scan of that answer")
        self.assertIn("on walls", self.text("#fit-pictures .legend"))
        self.assertIn("Localized", self.text("#robot-head .badge"))
        self.assertIn("Standard deviation", self.text("#robot-facts"))
        self.wait_for_text("#map-caption", f"Answer {self.first_recorded} of")
        self.screenshot("playback-answer")
        # The slider goes on to where the robot became lost, and the address with it.
        self.find("#history-step").send_keys(Keys.END)
        last = self.history[-1]["sequence"]
        self.wait_for_text("#history-entry", f"Answer {last},")
        self.wait_for_text("#robot-why", "no longer fit")
        self.wait_for(lambda: self.fragment().get("answer") == str(last), "the answer in the address")
        self.find("#step-live").click()
        self.wait_for(lambda: "answer" not in self.fragment(), "the newest answer")

    def test_an_answer_without_its_scan_says_so(self):
        self.open_answer(0)
        self.assertIn("did not keep the scan", self.text("#history-entry"))
        self.wait_for_text("#history-entry", f"Answers with their scan: {RECORDED} of {len(self.history)}")
        self.assertFalse(self.is_shown("#robot-fit"))

    def test_the_timeline_leads_to_where_the_status_changed(self):
        self.open(f"#session={self.robot.id}")
        self.wait_for(lambda: self.all('#timeline [data-status="lost"]'), "the timeline")
        self.find('#timeline [data-status="lost"]').click()
        first_lost = next(answer["sequence"] for answer in self.history if answer["status"] == "lost")
        self.wait_for_text("#history-entry", f"Answer {first_lost},")
        self.assertIn("Lost, contradicted", self.text("#history-entry"))

    def test_a_recording_is_saved_and_played_from_the_file(self):
        file = self.save_recording()
        recording = json.loads(file.read_text())
        self.assertEqual(recording["robot"], "cart-7")
        self.assertEqual([answer["sequence"] for answer in recording["answers"]],
                         [answer["sequence"] for answer in self.history])
        self.assertEqual(sum("scan_points" in answer for answer in recording["answers"]), RECORDED)

        self.open("#map=willow")
        self.find("#recording-file").send_keys(str(file))
        self.wait_for_text("#recording-name", "cart-7")
        self.assertFalse(self.is_shown("#robot-buttons"))
        self.wait_for_text("#history-entry", "Answer 0,")
        self.find("#history-step").send_keys(Keys.END)
        self.wait_for_text("#robot-why", "no longer fit")
        self.wait_for(lambda: self.all("#fit-pictures canvas"), "the scan")
        self.screenshot("playback-file")
        # What the page showed is kept, since a slow computer may look too late.
        self.browser.execute_script("""
          window.seen = new Set();
          new MutationObserver(() => ['play-history', 'history-entry'].forEach((id) => window.seen.add(document.getElementById(id).textContent)))
            .observe(document.getElementById('robot-history'), {childList: true, characterData: true, subtree: true});""")
        self.find("#play-history").click()
        self.wait_for(lambda: "Play" in self.browser.execute_script("return [...window.seen]"), "the end")
        seen = self.browser.execute_script("return [...window.seen]")
        self.assertIn("Pause", seen)
        for answer in self.history:
            self.assertIn(f"Answer {answer['sequence']},", " ".join(seen))
        self.assertIn(f"Answer {self.history[-1]['sequence']},", self.text("#history-entry"))
        self.find("#close-recording").click()
        self.wait_for(lambda: not self.is_shown("#recording-bar"), "no recording")

    def test_what_the_server_answers_is_a_recording_that_may_be_dropped(self):
        answer = self.server.call("GET", f"/v1/sessions/{self.robot.id}/history")
        self.open("#map=willow")
        self.browser.execute_script("""
          const files = new DataTransfer();
          files.items.add(new File([arguments[0]], 'failed-start.json'));
          document.body.dispatchEvent(new DragEvent('drop', {dataTransfer: files, bubbles: true, cancelable: true}));
        """, json.dumps(answer))
        self.wait_for_text("#recording-name", f"failed-start.json: {len(answer['answers'])} answers")

    def test_a_file_that_is_no_recording_is_refused(self):
        self.open("#map=willow")
        for text, reason in (("{", "is no JSON file"), ("{}", 'it has no "answers"'),
                             ('{"answers": [{"sequence": 1, "status": "found"}]}', "answer 1 of 1 has no")):
            file = self.directory / "wrong.json"
            file.write_text(text)
            self.find("#recording-file").send_keys(str(file))
            self.wait_for_text("#notice", reason)
            self.assertFalse(self.is_shown("#recording-bar"))


if __name__ == "__main__":
    main(__doc__)
