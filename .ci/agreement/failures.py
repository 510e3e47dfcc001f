"""What was found to disagree."""

N_SHOWN = 20


class Failures(list[str]):
    """Messages, one for each disagreement."""

    def check(self, is_good: bool, message: str) -> None:
        if not is_good:
            self.append(message)

    def print(self) -> None:
        for failure in self[:N_SHOWN]:
            print(f"DISAGREES {failure}")
        print(f"{len(self)} disagreements")
