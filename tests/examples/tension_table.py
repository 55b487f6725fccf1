"""Table 1 of the paper, measured again: every scene and strategy, next to the published numbers."""
import elastin

for letter in "abcd":
    scene = f"scenes/tension/table1-{letter}.yaml"
    published = {said["strategy"]: said["value"] for said in elastin.Laboratory(scene).expectations}
    for result in elastin.compare(scene):
        E = result.get("effective_modulus", float("nan"))
        print(f"{result.scene}  {result.strategy:14}{E:12.4f} Pa   published {published.get(result.strategy)}")
