package crcl.ui.client;

import aprsim.Console;
import crcl.base.CommandStatusType;
import crcl.base.PoseType;
import crcl.ui.DefaultSchemaFiles;
import crcl.utils.stubs.PendantClientOuterStub;
import java.io.File;

/**
 * NIST's pendant client without a display. connect; test; program FILE; pause; resume; abort; state; disconnect. Where: the
 * client's own properties crcl4java.host and crcl4java.port. In the client's package, as its constructor is.
 */
public final class PendantDriver {
  private static CrclSwingClientInner client;

  public static void main(String[] unused) throws Exception {
    System.setProperty("crcjava.PendandClient.useReadStatusThreadSelected", "false");
    PendantClientOuterStub outer = new PendantClientOuterStub();
    client = new CrclSwingClientInner(outer, DefaultSchemaFiles.instance());
    client.setQuitOnTestCommandFailure(true);
    client.setValidateXmlSchema(Boolean.getBoolean("validate"));
    Console.serve(
        (command, arguments) -> {
          switch (command) {
            case "connect":
              client.connect(outer.getHost(), outer.getPort());
              return String.valueOf(client.isConnected());
            case "disconnect":
              client.disconnect();
              return String.valueOf(client.isConnected());
            case "test":
              start(command, () -> client.runTest(client.getDefaultTestPropertiesMap()));
              return null;
            case "program":
              client.openXmlProgramFile(new File(arguments[0]), false);
              // As the panel's own button does it.
              start(command, () -> client.startRunProgramThread(0, true).get());
              return null;
            case "pause":
              client.pause();
              return "done";
            case "resume":
              client.unpause();
              return "done";
            case "abort":
              client.abort();
              return "done";
            case "state":
              return state();
            default:
              throw new IllegalArgumentException(command);
          }
        });
  }

  private interface Work {
    boolean run() throws Exception;
  }

  private static void start(String name, Work work) {
    new Thread(
            () -> {
              try {
                boolean good = work.run();
                Console.say(name + " ended " + good + (good ? "" : " " + client.getLastMessage()));
              } catch (Throwable fault) {
                fault.printStackTrace();
                Console.say(name + " ended false " + Console.reason(fault));
              }
            })
        .start();
  }

  private static String state() {
    PoseType pose = client.currentStatusPose();
    CommandStatusType status = client.getStatus().getCommandStatus();
    return status.getCommandState()
        + " "
        + status.getCommandID()
        + (pose == null
            ? ""
            : " at " + pose.getPoint().getX() + " " + pose.getPoint().getY() + " " + pose.getPoint().getZ())
        + " line " + client.getCurrentProgramLine()
        + " "
        + status.getStateDescription();
  }
}
