"""A scene through its files."""

from pathlib import Path

from crosscheck.scene import Scene


def assert_survives_files(scene: Scene, directory: Path) -> None:
    """TOML and JSON give back an equal scene."""
    assert Scene.from_json(scene.to_json()) == scene
    path = directory / "scene.toml"
    path.write_text(scene.to_toml(), encoding="utf-8", newline="")
    again = Scene.load(path)
    assert again == scene
    assert again.to_toml() == scene.to_toml()
    assert scene.changed() == scene
