// gnomonctl: the operators' command line tool for a running gnomond.
#include <unistd.h>

#include <cstdio>
#include <functional>
#include <iostream>

#include "daemon/ctl/arguments.h"
#include "daemon/ctl/fleet_commands.h"
#include "daemon/ctl/scene_load.h"
#include "daemon/ctl/top.h"
#include "daemon/ctl/usage.h"
#include "daemon/ctl/views.h"

namespace gnomon::ctl {
namespace {

using View = std::string (*)(const nlohmann::json&);

Result<AdminClient> client(Arguments& arguments) {
  if (!arguments.fleet.empty())
    return wrong_usage(arguments,
                       Error{"--fleet: allowed with status, drain, undrain, scene light and scene lights"});
  if (const std::string& said = arguments.admin.address; !said.empty()) {
    if (const auto address = parse_admin_address(said); !address) return wrong_usage(arguments, address.error());
  }
  auto access = access_of(arguments);
  if (!access) return access.error();
  return AdminClient(std::move(*access));
}

// `key`: the member of /status that --json prints; if empty, all of it.
Command show(View view, std::string key) {
  return [view, key = std::move(key)](Arguments& arguments) -> Result<void> {
    auto admin = client(arguments);
    if (!admin) return admin.error();
    const auto status = admin->status();
    if (!status) return status.error();
    const auto part = key.empty() ? *status : status->value(key, nlohmann::json::array());
    print(arguments.json ? json_text(part, 2) : view(*status));
    return {};
  };
}

Result<void> post(Arguments& arguments, const std::string& path,
                  const nlohmann::json& body = nlohmann::json::object()) {
  auto admin = client(arguments);
  if (!admin) return admin.error();
  const auto answer = admin->post(path, body);
  if (!answer) return answer.error();
  print(arguments.json ? json_text({{"answer", *answer}}, -1) : *answer + "\n");
  return {};
}

Command drains(const char* path) {
  return [path](Arguments& arguments) {
    return arguments.fleet.empty() ? post(arguments, path) : post_to_node(arguments, path);
  };
}

Result<void> change_light(Arguments& arguments) {
  const std::string path = "/scenes/" + arguments.scene + "/lights/" + std::to_string(arguments.light);
  if (arguments.light_change.empty()) {
    return wrong_usage(arguments, Error{"nothing is to be changed; --help says what can be"});
  }
  return arguments.fleet.empty() ? post(arguments, path, arguments.light_change)
                                 : change_light_of_fleet(arguments, path);
}

Result<void> show_lights(Arguments& arguments) {
  if (!arguments.fleet.empty()) return share_lights(arguments);
  if (!arguments.lights_file.empty()) return wrong_usage(arguments, Error{"--file: allowed with --fleet"});
  auto admin = client(arguments);
  if (!admin) return admin.error();
  const auto lights = admin->get("/lights");
  if (!lights) return lights.error();
  print(arguments.json ? json_text(*lights, 2) : lights_text(*lights));
  return {};
}

Result<void> kick(Arguments& arguments) {
  nlohmann::json body = nlohmann::json::object();
  if (!arguments.why.empty()) body["why"] = arguments.why;
  if (arguments.stay_out_s) body["for_s"] = *arguments.stay_out_s;
  return post(arguments, "/sessions/" + arguments.session + "/kick", body);
}

Result<void> unload(Arguments& arguments) { return post(arguments, "/scenes/" + arguments.scene + "/unload"); }

Result<void> load(Arguments& arguments) {
  auto admin = client(arguments);
  if (!admin) return admin.error();
  const auto answer = load_scene(*admin, arguments.scene);
  if (!answer) return answer.error();
  print(arguments.json ? json_text({{"answer", *answer}}, -1) : *answer + "\n");
  return {};
}

Result<void> live(Arguments& arguments) {
  auto admin = client(arguments);
  if (!admin) return admin.error();
  const auto interval = std::chrono::milliseconds(static_cast<int64_t>(arguments.interval_s * 1000));
  return top(*admin, {interval, arguments.count, arguments.json});
}

// Adds a subcommand that sets `chosen` when it is named.
CLI::App* add(CLI::App& app, Command& chosen, const char* name, const char* help, Command command) {
  CLI::App* sub = app.add_subcommand(name, help);
  sub->fallthrough();  // --admin and the others may also follow the subcommand
  if (command) sub->callback([&chosen, command = std::move(command)] { chosen = command; });
  return sub;
}

void add_scene_commands(CLI::App& app, Command& chosen, Arguments& arguments) {
  CLI::App* scene = add(app, chosen, "scene", "List, load or unload scenes", nullptr);
  scene->require_subcommand(1);
  add(*scene, chosen, "list", "The scenes on the device", show(scenes_text, "scenes"));
  CLI::App* lights =
      add(*scene, chosen, "lights",
          "What was changed of lights; with --fleet every node learns what the others know", show_lights);
  lights->add_option("--file", arguments.lights_file, "With --fleet: where a node that is about to start finds it")
      ->type_name("FILE");
  CLI::App* light =
      add(*scene, chosen, "light", "Change a light of a scene; with --fleet on every node", change_light);
  light->add_option("NAME", arguments.scene, "As clients ask for it")->required()->type_name("SCENE");
  light->add_option("NUMBER", arguments.light, "Its place in the scene's list, from 0")->required();
  nlohmann::json& change = arguments.light_change;
  light->add_flag_callback(
      "--on", [&change] { change["on"] = true; }, "As bright as in its file");
  light
      ->add_flag_callback(
          "--off", [&change] { change["on"] = false; }, "Dark")
      ->excludes("--on");
  light->add_flag_callback(
      "--as-in-file", [&change] { change["as_in_file"] = true; }, "Forgets what was changed of it before");
  light
      ->add_option_function<double>(
          "--intensity", [&change](double to) { change["intensity"] = to; }, "Candela, or lux of a directional one")
      ->check([](const std::string& text) {
        return CLI::NonNegativeNumber(text).empty() ? "" : "a number from 0 on, not " + text;
      })
      ->type_name("N");
  light
      ->add_option_function<std::vector<double>>(
          "--color", [&change](const auto& to) { change["color"] = to; },
          "Linear, three numbers from 0 on with commas")
      ->delimiter(',')
      ->expected(3)
      ->type_name("R,G,B");
  CLI::App* both[] = {
      add(*scene, chosen, "load", "Bring a scene of the configuration to the device; shows how far it is", load),
      add(*scene, chosen, "unload",
          "Take a scene that nobody uses off the device; its file is read anew when asked for", unload)};
  for (CLI::App* each : both)
    each->add_option("NAME", arguments.scene, "As clients ask for it")->required()->type_name("SCENE");
}

void add_device_commands(CLI::App& app, Command& chosen, Arguments& arguments) {
  CLI::App* device = add(app, chosen, "device", "Take sessions off a device, or let it take some again", nullptr);
  device->require_subcommand(1);
  for (const std::string what : {"drain", "resume"}) {
    const char* help = what == "drain" ? "Its sessions move to the others, and it gets no new ones"
                                       : "It takes sessions again, and some of the others'";
    CLI::App* sub = add(*device, chosen, what.c_str(), help, [what](Arguments& a) {
      return post(a, "/devices/" + std::to_string(a.device) + "/" + what);
    });
    sub->add_option("NUMBER", arguments.device, "Its place in render.devices, as `status` shows it")->required();
  }
}

void add_commands(CLI::App& app, Command& chosen, Arguments& arguments) {
  add(app, chosen, "status", "Devices, scenes and tenants; with --fleet the nodes",
      [alone = show(status_text, "")](Arguments& a) { return a.fleet.empty() ? alone(a) : show_fleet(a); });
  add(app, chosen, "sessions", "Open sessions with their latencies", show(sessions_text, "sessions"));
  CLI::App* top_command = add(app, chosen, "top", "A live table of tenants and sessions", live);
  top_command->add_option("--interval", arguments.interval_s, "Seconds between two tables")
      ->check(CLI::Range(0.1, 3600.0))
      ->type_name("SECONDS");
  top_command->add_option("--count", arguments.count, "Tables before it ends; 0: until it is left or interrupted")
      ->type_name("N");
  add(app, chosen, "reload",
      "Read the configuration again; sessions stay, but for those whose tenant or credential is gone",
      [](Arguments& a) { return post(a, "/reload"); });
  CLI::App* both[] = {
      add(app, chosen, "drain", "Admit nobody, serve those who are here on, and ask clients of a fleet to move",
          drains("/drain")),
      add(app, chosen, "undrain", "Admit clients again", drains("/undrain"))};
  for (CLI::App* each : both)
    each->add_option("--node", arguments.node, "With --fleet: which one")->type_name("NAME");
  add(app, chosen, "stop", "Admit nobody, tell the clients, then end the daemon",
      [](Arguments& a) { return post(a, "/stop"); });
  CLI::App* kick_command = add(app, chosen, "kick", "Close a session and keep its client out for a time", kick);
  kick_command->add_option("SESSION", arguments.session, "Its id, as `sessions` shows it")
      ->required()
      ->check(is_session_id());
  kick_command->add_option("--why", arguments.why, "What the client is told");
  kick_command
      ->add_option("--for", arguments.stay_out_s,
                   "How long clients of its tenant at its address stay out: 90s, 5m, 2h; 0: not at all; else 60s")
      ->transform(seconds_with_unit());
  add_scene_commands(app, chosen, arguments);
  add_device_commands(app, chosen, arguments);
}

// What is not said is asked for, where there is somebody to ask.
Result<void> make_production(Arguments& arguments) {
  InitRequest request = arguments.init;
  if (auto taken = take_from_before(request); !taken) return taken.error();
  if (isatty(STDIN_FILENO) == 1) ask_for_missing(request, std::cin, std::cout);
  if (auto understood = check_init(request); !understood) return wrong_usage(arguments, understood.error());
  const auto made = init(request);
  if (!made) return made.error();
  print(*made);
  return {};
}

void add_fleet_options(CLI::App& command, InitRequest& request) {
  command.add_option("--fleet", request.fleet, "Name of the fleet that the node is of; it is the host too")
      ->type_name("NAME");
  command
      .add_option("--public-address", request.public_address, "In a fleet: where its clients send their datagrams")
      ->type_name("ADDRESS");
  command
      .add_option("--proxies", request.proxies,
                  "In a fleet: addresses of the doors, or their networks; several in turn, or with commas")
      ->delimiter(',')
      ->type_name("ADDRESS");
  command
      .add_option("--door-listen", request.door_listen, "In a fleet: which address doors ask; else the public one")
      ->type_name("ADDRESS");
  command.add_option("--door-port", request.door_port, "In a fleet: which port doors ask")
      ->default_str("7602")
      ->check(CLI::Range(1, 65535))
      ->type_name("N");
}

void add_init_command(CLI::App& app, Command& chosen, InitRequest& request) {
  CLI::App* command =
      add(app, chosen, "init",
          "Write what production needs: configuration, certificates, tokens, ports; asks for the rest",
          make_production);
  command
      ->add_option("--host", request.hosts, "Name or address by which clients reach this machine; several in turn")
      ->type_name("HOST");
  command->add_option("--tenant", request.tenants, "Who is served; several in turn; else default")
      ->type_name("NAME");
  command
      ->add_option("--scene", request.scenes, "living_room, temple, NAME=FILE or FILE; several in turn; else both")
      ->type_name("SCENE");
  command->add_option("--out", request.out, "Folder of the configuration")->type_name("DIR");
  command->add_option("--listen", request.listen, "Address of the clients' ports")
      ->default_str("0.0.0.0")
      ->type_name("ADDRESS");
  command->add_option("--port", request.port, "Clients' port, TCP and UDP")
      ->default_str("7600")
      ->check(CLI::Range(1, 65535))
      ->type_name("N");
  command->add_option("--days", request.days, "How long the server's certificate lasts")
      ->check(CLI::Range(1u, 3650u))
      ->type_name("DAYS");
  // By a function, as a flag of an optional would be set to false where it is not given.
  command->add_flag_function(
      "--browsers,!--no-browsers", [&request](int64_t count) { request.browsers = count > 0; },
      "Serve the viewer for browsers too (web.listen)");
  command->add_option("--systemd", request.systemd, "Folder of units, for the socket's drop-in; else the system's")
      ->type_name("DIR");
  add_fleet_options(*command, request);
}

void add_fleet_commands(CLI::App& app, Command& chosen, DoorRequest& door) {
  CLI::App* fleet = add(app, chosen, "fleet", "Make what a fleet of many nodes needs", nullptr);
  fleet->require_subcommand(1);
  CLI::App* haproxy = add(*fleet, chosen, "haproxy", "Write the configuration of HAProxy, which is its door",
                          [](Arguments& a) -> Result<void> {
                            const auto text = haproxy_text(a.door);
                            if (!text) return wrong_usage(a, text.error());
                            print(*text);
                            return {};
                          });
  haproxy->add_option("--node", door.nodes, "A node's name and control address; several in turn")
      ->required()
      ->type_name("NAME=HOST[:PORT]");
  haproxy->add_option("--listen", door.listen, "Where clients come")->type_name("[ADDRESS]:PORT");
  haproxy->add_option("--door-port", door.door_port, "The nodes' fleet.door_port")
      ->check(CLI::Range(1, 65535))
      ->type_name("N");
  haproxy->add_option("--max-connections", door.max_connections, "Sessions and those that are on their way to one")
      ->check(CLI::Range(1u, 1'000'000u))
      ->type_name("N");
}

void add_secret_commands(CLI::App& app, Command& chosen, CertsRequest& request) {
  CLI::App* certs = add(app, chosen, "make-certs", "Make the certificates that gnomond and its clients need",
                        [](const Arguments& a) -> Result<void> {
                          const auto made = make_certs(a.certs);
                          if (!made) return made.error();
                          print(*made);
                          return {};
                        });
  certs->add_option("--out", request.out, "Folder for them")->required()->type_name("DIR");
  certs->add_option("--host", request.hosts, "Name or address by which clients reach the server")
      ->required()
      ->type_name("HOST");
  certs->add_option("--fleet", request.fleet, "Fleet that the server is of: its name, and those of its scenes")
      ->type_name("NAME");
  certs->add_option("--client", request.tenants, "Tenant whose clients get a certificate, in the place of a token")
      ->type_name("NAME");
  certs->add_option("--days", request.days, "How long they last")->check(CLI::Range(1u, 3650u))->type_name("DAYS");
  certs->add_flag("--renew", request.renew, "Replace those that are there");
  add(app, chosen, "make-token", "Make a tenant's token, and the hash of it for gnomond's configuration",
      [](const Arguments&) -> Result<void> {
        print(token_text());
        return {};
      });
}

int run(int argc, char** argv) {
  Arguments arguments;
  Command chosen;
  CLI::App app{"Asks a running gnomond, or tells it what to do."};
  app.option_defaults()->always_capture_default();
  const CLI::Option* const admin =
      app.add_option(
             "--admin", arguments.admin.address,
             "gnomond's admin server: unix:PATH, http://HOST:PORT or https://HOST:PORT; else its usual socket")
          ->type_name("ADDRESS")
          ->envname("GNOMON_ADMIN");
  app.add_option("--token-file", arguments.token_file, "Its token, for what changes something over TCP")
      ->type_name("FILE")
      ->envname("GNOMON_TOKEN_FILE");
  app.add_option("--ca", arguments.admin.authority,
                 "Who signed its certificate, for https; else whom the system trusts")
      ->type_name("FILE")
      ->envname("GNOMON_ADMIN_CA");
  app.add_option("--name", arguments.admin.name,
                 "The name in its certificate, where the address has another one: that of a fleet")
      ->type_name("NAME")
      ->envname("GNOMON_ADMIN_NAME");
  const CLI::Option* const fleet =
      app.add_option(
             "--fleet", arguments.fleet,
             "The nodes of a fleet, in the place of --admin: a file with lines NAME ADDRESS, or NAME=ADDRESS,...")
          ->type_name("FILE|NODES")
          ->envname("GNOMON_FLEET");
  app.add_flag("--json", arguments.json, "For programs");
  app.set_version_flag("--version", "gnomonctl " GNOMON_VERSION);
  app.require_subcommand(1);
  add_commands(app, chosen, arguments);
  add_init_command(app, chosen, arguments.init);
  add_secret_commands(app, chosen, arguments.certs);
  add_fleet_commands(app, chosen, arguments.door);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& ended) {
    return exit_after(app, ended);
  }
  if (is_said(app, admin) && !is_said(app, fleet)) arguments.fleet.clear();  // the environment's
  Result<void> done;
  try {
    done = chosen(arguments);
  } catch (const std::filesystem::filesystem_error& error) {  // a folder that may not be looked into
    done = Error{error.path1().string() + ": " + error.code().message()};
  }
  if (done) return EXIT_SUCCESS;
  std::fprintf(stderr, "gnomonctl: %s\n", done.error().message.c_str());
  return arguments.exit_after_error;
}

}  // namespace
}  // namespace gnomon::ctl

int main(int argc, char** argv) { return gnomon::ctl::run(argc, argv); }
